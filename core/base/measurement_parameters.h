/// Parameters of the model, the camera images, the depth images and the likelihood.
///
/// Every struct lists its fields once, in `visit`, with unit, range and meaning. Reading, checking,
/// printing and the documentation use that list.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameter_range.h"

namespace edge_mcl {

/// The 3D model and how its edges are found.
struct MapParameters {
  double scale = 0;
  double x = 0, y = 0, z = 0;
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
  std::string mirror = "none";
  std::string origin = "auto";
  bool absolute_poses = true;
  std::string include, exclude;
  double crease_angle_deg = 27;
  bool boundaries = true;
  bool material_borders = true;
  bool contours = true;
  double weld_tolerance = 0;
  double sample_step = 0;
  double min_line_length = 0;
  bool seams = false;
  std::string confidence;
  double min_confidence = 0.5;
  std::string additions;
  double import_seconds = 0;
  double import_gigabytes = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("scale", scale, "", notNegative(),
      "factor from the file's unit to metres; 0 = the unit that the file states, else the metre");
    v("x", x, "m", anyValue(), "position of the file's origin in the map");
    v("y", y, "m", anyValue(), "position of the file's origin in the map");
    v("z", z, "m", anyValue(), "position of the file's origin in the map");
    v("yaw_deg", yaw_deg, "deg", anyValue(), "rotation of the file's axes in the map, about z");
    v("pitch_deg", pitch_deg, "deg", anyValue(), "rotation after yaw, about the new y axis");
    v("roll_deg", roll_deg, "deg", anyValue(), "rotation after pitch, about the new x axis");
    v("mirror", mirror, "", oneOf("none|x|y|z"), "axis of the file whose sign is changed");
    v("origin", origin, "m", anyValue(),
      "position of the map frame in the file's coordinates: X,Y,Z, or auto: 0,0,0 unless the model "
      "is more than 5 km from there, then its middle rounded to 100 m");
    v("absolute_poses", absolute_poses, "", anyValue(),
      "poses of recordings and of the results of tools are in the file's coordinates; false = they "
      "are relative to the origin of the map frame. The nodes' poses are always relative to it");
    v("include", include, "", anyValue(),
      "names of the objects to read, with commas between; * = any text, ? = one character; empty = "
      "all");
    v("exclude", exclude, "", anyValue(),
      "names of the objects not to read, like include, e.g. *Furniture*,*Ceiling*");
    v("crease_angle_deg", crease_angle_deg, "deg", between(0, 180),
      "an edge is a crease when its two faces meet at this dihedral angle or more");
    v("boundaries", boundaries, "", anyValue(), "edges with only one face are feature edges");
    v("material_borders", material_borders, "", anyValue(),
      "edges between two materials are feature edges");
    v("contours", contours, "", anyValue(),
      "outlines of smooth surfaces are edges; they depend on the viewpoint");
    v("weld_tolerance", weld_tolerance, "m", notNegative(),
      "vertices closer than this are joined; 0 = automatic");
    v("sample_step", sample_step, "m", notNegative(),
      "distance between samples along a line; 0 = automatic");
    v("min_line_length", min_line_length, "m", notNegative(),
      "feature lines shorter than this are ignored");
    v("seams", seams, "", anyValue(),
      "edges that are not seen are feature edges, too: seams in flat surfaces, and edges that "
      "other "
      "parts cover");
    v("confidence", confidence, "", anyValue(),
      "table that `edge-mcl audit` has written: its lines and shapes of low confidence are left "
      "out "
      "of the map; empty = none");
    v("min_confidence", min_confidence, "", between(0, 1),
      "lines and shapes with a lower confidence are left out");
    v("additions", additions, "", anyValue(),
      "files with what the building has and the model lacks, with commas between, as `edge-mcl "
      "audit "
      "--add` writes them; metres, in the coordinates of the model file after scale and transform; "
      "empty = none");
    v("import_seconds", import_seconds, "s", notNegative(),
      "longest time for reading the model file; 0 = 20 s, and 2 s for each megabyte");
    v("import_gigabytes", import_gigabytes, "GB", notNegative(),
      "most memory for reading the model file; 0 = 4 GB, and 60 times the size of the file");
  }
  /// What is wrong with texts, one text each.
  std::vector<std::string> faults() const;
  /// Origin of the map frame in the file's coordinates, m. Empty: automatic.
  std::optional<std::array<double, 3>> givenOrigin() const;
};

/// Hidden-line removal.
struct VisibilityParameters {
  double cell_size = 0;
  double cache_megabytes = 256;
  double occlusion_tolerance = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("cell_size", cell_size, "m", notNegative(),
      "size of the cells of space in which all camera positions share one visible set; 0 = "
      "automatic");
    v("cache_megabytes", cache_megabytes, "MB", positive(),
      "most memory for visible sets of cells; the least recently used one is dropped");
    v("occlusion_tolerance", occlusion_tolerance, "m", notNegative(),
      "a surface closer to a sample than this does not hide it; 0 = automatic");
  }
};

/// Edges of the camera image and the table made from them.
struct ImageParameters {
  double blur_sigma = 1.0;
  double edge_share = 0.08;
  double noise_factor = 4.0;
  double hysteresis = 0.4;
  int contrast_window = 88;
  bool straight_segments = false;
  double min_segment_length = 20;
  int mask_dilation = 5;
  int orientation_bins = 12;
  double orientation_tolerance_deg = 20;
  int search_length = 24;
  int clutter_window = 88;
  int reference_width = 640;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("blur_sigma", blur_sigma, "px", below(0, 20),
      "standard deviation of the Gaussian smoothing before the gradient");
    v("edge_share", edge_share, "", between(0, 1),
      "share of all pixels whose gradient is strong enough to start an edge");
    v("noise_factor", noise_factor, "", notNegative(),
      "the gradient of an edge exceeds the image noise by this factor");
    v("hysteresis", hysteresis, "", above(0, 1),
      "threshold to continue an edge, as a fraction of the threshold to start one");
    v("contrast_window", contrast_window, "px", from(0, 2000),
      "side of the window in which a dull part of the image gets a lower threshold; 0 = one "
      "threshold for the whole image");
    v("straight_segments", straight_segments, "", anyValue(),
      "only edge pixels on straight segments are used");
    v("min_segment_length", min_segment_length, "px", positive(), "shortest straight segment");
    v("mask_dilation", mask_dilation, "px", from(0, 100),
      "the mask grows by this much, so that the outline of a masked object is masked as well");
    v("orientation_bins", orientation_bins, "", from(4, 64),
      "number of edge directions that the table distinguishes");
    v("orientation_tolerance_deg", orientation_tolerance_deg, "deg", above(0, 90),
      "largest angle between a model edge and the image edge matched to it");
    v("search_length", search_length, "px", from(2, 200),
      "length of the normals; an image edge farther away counts as no edge");
    v("clutter_window", clutter_window, "px", from(16, 2000),
      "robust model: side of the window in which the density of image edges is measured");
    v("reference_width", reference_width, "px", from(0, 100000),
      "all lengths in pixels (image, likelihood, refinement, tracking.min_edge_pixels) hold for "
      "4:3 images of this width and are scaled for images of another size; 0 = they hold for "
      "every image");
  }
};

enum class LikelihoodModel { kPaper, kRobust };

/// The sensor data that poses are compared with.
enum class Cues { kEdges, kDepth, kBoth };

enum class BackendChoice { kAuto, kCpu, kCuda };

/// The measurement model, see docs/likelihood.md.
struct LikelihoodParameters {
  Cues cues = Cues::kEdges;
  LikelihoodModel model = LikelihoodModel::kRobust;
  double sigma = 2;
  double alpha = 1;
  double k = 60;
  double missing_edge = 0.35;
  double line_saturation = 6;
  double correlation_length = 4;
  double line_correlation = 0.5;
  double scale = 8;
  double border_fade = 4;
  int max_samples = 1000;
  BackendChoice backend = BackendChoice::kAuto;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("cues", cues, "", anyValue(), "data used: edges of camera images, depth images, or both");
    v("model", model, "", anyValue(),
      "paper: equations (1)-(3); robust: log-ratio against \"no model edge here\"");
    v("sigma", sigma, "px", positive(),
      "standard deviation of an image edge's distance along the normal, eq. (1)");
    v("alpha", alpha, "", positive(), "paper model: factor of eq. (3)");
    v("k", k, "", positive(), "paper model: exponent of eq. (3)");
    v("missing_edge", missing_edge, "", between(0, 1),
      "robust model: probability that a visible model edge leaves no edge in the image");
    v("line_saturation", line_saturation, "samples", positive(),
      "robust model: the samples of one line count as at most this many independent ones");
    v("correlation_length", correlation_length, "px", positive(),
      "robust model: samples of a line closer than this in the image count only in part");
    v("line_correlation", line_correlation, "", from(0, 1),
      "robust model: correlation between lines; 0 adds their scores, 1 averages them as eq. (3)");
    v("scale", scale, "", positive(),
      "robust model: factor on the log-likelihood, see line_correlation");
    v("border_fade", border_fade, "px", notNegative(),
      "the weight of a sample rises from 0 to 1 over this distance from the image border");
    v("max_samples", max_samples, "", notNegative(),
      "samples per particle and image in an update; more are thinned out evenly; 0 = all");
    v("backend", backend, "", anyValue(),
      "device that computes the likelihood; auto = cuda where a device answers, else cpu");
  }
};

/// Depth images against the model's surfaces, see docs/likelihood.md.
struct DepthParameters {
  double truncation = 0.3;
  double voxel_size = 0;
  bool store_field = true;
  double field_megabytes = 256;
  int points = 500;
  double min_range = 0.3;
  double max_range = 8;
  double sigma = 0.02;
  double sigma_per_square_metre = 0.0015;
  double bias_sigma = 0.002;
  double clutter = 0.3;
  double independent_points = 40;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("truncation", truncation, "m", above(0, 5),
      "points farther from every surface than this are clutter");
    v("voxel_size", voxel_size, "m", notNegative(),
      "grid size of the distance field; 0 = automatic: 4 cm, larger in large models");
    v("store_field", store_field, "", anyValue(),
      "the distance field is kept on disk, beside the model or in the user's cache directory");
    v("field_megabytes", field_megabytes, "MB", from(1, 100000),
      "most memory for the distance field; automatic voxels grow until it is enough");
    v("points", points, "", from(10, 1000000), "number of points taken from a depth image");
    v("min_range", min_range, "m", notNegative(), "smaller depths are not used");
    v("max_range", max_range, "m", notNegative(), "larger depths are not used");
    v("sigma", sigma, "m", positive(),
      "standard deviation of a point's distance from its surface, at depth 0");
    v("sigma_per_square_metre", sigma_per_square_metre, "m/m^2", notNegative(),
      "increase of that standard deviation, times the square of the depth");
    v("bias_sigma", bias_sigma, "1/m", notNegative(),
      "standard deviation of b in a calibration error b z^2 of the depth, which the filter learns; "
      "0 = no such error");
    v("clutter", clutter, "", below(1e-3, 1), "probability that a point is not on the model");
    v("independent_points", independent_points, "", positive(),
      "all points of an image together count as this many independent ones");
  }
};

/// Gauss-Newton refinement of a pose on the same residuals.
struct RefinementParameters {
  bool enabled = true;
  int iterations = 10;
  double search_length = 16;
  double final_search_length = 6;
  double sigma = 1.5;
  int starts = 6;
  int max_samples = 800;
  int start_iterations = 5;
  int start_samples = 400;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("enabled", enabled, "", anyValue(),
      "the best particles are refined, and particles are drawn from the results");
    v("iterations", iterations, "", from(1, 1000), "number of Gauss-Newton steps");
    v("search_length", search_length, "px", from(1, 200),
      "length of the normals at the first step");
    v("final_search_length", final_search_length, "px", from(1, 200),
      "length of the normals at the last step");
    v("sigma", sigma, "px", positive(),
      "standard deviation of an image edge's position along the normal");
    v("starts", starts, "", from(1, 1000), "number of particles from which refinement starts");
    v("max_samples", max_samples, "", atLeast(20),
      "samples used per camera; more are thinned out evenly");
    v("start_iterations", start_iterations, "", from(1, 1000),
      "Gauss-Newton steps from each of the `starts`, whose results only guide particles");
    v("start_samples", start_samples, "", atLeast(6), "samples used in those steps");
  }
};

}  // namespace edge_mcl
