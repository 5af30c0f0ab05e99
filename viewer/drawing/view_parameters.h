/// Parameters of the viewer's picture.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/base/parameter_range.h"

namespace edge_mcl {

/// Functions of parameter_struct.h apply.
struct ViewParameters {
  int width = 1280, height = 720;
  std::string model_style = "solid";
  bool follow = true;
  double azimuth = -60;
  double elevation = 50;
  double zoom = 1;
  double cut_above = 0.5;
  int max_particles = 2000;
  bool model_edges = true, image_edges = true, normals = true;
  bool mask = true;
  bool depth_points = true;
  double strip_seconds = 30;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("width", width, "px", from(640, 7680), "width of the window or picture, an even number");
    v("height", height, "px", from(400, 4320), "height of the window or picture, an even number");
    v("model_style", model_style, "", oneOf("solid|ghost|wireframe"),
      "how the model is drawn; a ghost is transparent");
    v("follow", follow, "", anyValue(),
      "true: the robot is in the middle; false: the whole model is in view");
    v("azimuth", azimuth, "deg", from(-360, 360), "direction of the viewpoint about the z axis");
    v("elevation", elevation, "deg", from(-90, 90), "height of the viewpoint above the horizon");
    v("zoom", zoom, "", from(0.05, 50), "a larger value brings the viewpoint closer");
    v("cut_above", cut_above, "m", from(-1e6, 1e6),
      "the model is left out from this height above the camera upwards");
    v("max_particles", max_particles, "", from(1, 1000000), "largest number of particles drawn");
    v("model_edges", model_edges, "", anyValue(), "model edges are drawn in the camera image");
    v("image_edges", image_edges, "", anyValue(), "image edges are drawn in the camera image");
    v("normals", normals, "", anyValue(), "normals are drawn in the camera image");
    v("mask", mask, "", anyValue(), "the mask is drawn in the camera image");
    v("depth_points", depth_points, "", anyValue(), "depth points are drawn in the scene");
    v("strip_seconds", strip_seconds, "s", from(1, 3600), "time span of the strips at the bottom");
  }

  /// Faults that ranges do not tell, one text each.
  std::vector<std::string> faults() const;
  /// @throws ParameterError that lists all faults
  void validate() const;
  /// Sets a parameter from text. @throws ParameterError for an unknown name (with the nearest known
  /// one) or a value of the wrong type
  void set(const std::string& name, const std::string& value);
};

}  // namespace edge_mcl
