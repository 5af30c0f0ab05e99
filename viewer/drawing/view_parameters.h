/// What the viewer shows, and how.
#pragma once

#include <string>
#include <vector>

namespace edge_mcl {

struct ViewParameters {
  int width = 1280, height = 720;     ///< of the window or picture, pixels
  std::string model_style = "solid";  ///< solid, ghost (one can look through) or wireframe
  bool follow = true;                 ///< look at the robot; else at the whole model
  double azimuth = -60;               ///< deg, from where one looks
  double elevation = 50;              ///< deg, likewise
  double zoom = 1;                    ///< larger: from closer by
  double cut_above = 0.5;             ///< m above the camera; what is higher is left out
  int max_particles = 2000;           ///< shown at most
  bool model_edges = true, image_edges = true, normals = true;  ///< in the camera image
  bool mask = true;                                             ///< likewise
  bool depth_points = true;
  double strip_seconds = 30;  ///< of the strips below

  template <class Visitor>
  void visit(Visitor&& v) {
    v("width", width);
    v("height", height);
    v("model_style", model_style);
    v("follow", follow);
    v("azimuth", azimuth);
    v("elevation", elevation);
    v("zoom", zoom);
    v("cut_above", cut_above);
    v("max_particles", max_particles);
    v("model_edges", model_edges);
    v("image_edges", image_edges);
    v("normals", normals);
    v("mask", mask);
    v("depth_points", depth_points);
    v("strip_seconds", strip_seconds);
  }

  /// What is wrong with the values, one text each.
  std::vector<std::string> faults() const;
  /// @throws ParameterError listing all faults.
  void validate() const;
  /// From text. @throws ParameterError for an unknown name (naming the nearest) or a wrong value.
  void set(const std::string& name, const std::string& value);
};

}  // namespace edge_mcl
