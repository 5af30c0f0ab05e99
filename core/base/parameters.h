/// All parameters of the method, with defaults, units and one description each.
///
/// The same names are used in YAML (`group: {name: value}`), on the command line and in MRPT ini
/// files (`group.name`) and as ROS parameters (`group/name`). Every struct lists its fields once,
/// in `visit`; reading, printing and the documentation are made from that list.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace edge_mcl {

/// The 3D model and how its edges are found.
struct MapParameters {
  double scale = 1;
  double x = 0, y = 0, z = 0;
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
  double crease_angle_deg = 27;
  bool boundaries = true;
  bool material_borders = true;
  bool contours = true;
  double weld_tolerance = 0;
  double sample_step = 0;
  double min_line_length = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("scale", scale, "", "factor from file units to metres");
    v("x", x, "m", "position of the file's origin in the map");
    v("y", y, "m", "position of the file's origin in the map");
    v("z", z, "m", "position of the file's origin in the map");
    v("yaw_deg", yaw_deg, "deg", "rotation of the file's axes in the map, about z");
    v("pitch_deg", pitch_deg, "deg", "then about y");
    v("roll_deg", roll_deg, "deg", "then about x");
    v("crease_angle_deg", crease_angle_deg, "deg", "dihedral angle from which an edge is a crease");
    v("boundaries", boundaries, "", "edges with a single face are feature edges");
    v("material_borders", material_borders, "", "edges between materials are feature edges");
    v("contours", contours, "", "outlines of smooth surfaces, which depend on the viewpoint");
    v("weld_tolerance", weld_tolerance, "m", "vertices closer than this are one; 0 = automatic");
    v("sample_step", sample_step, "m", "distance of samples along a line; 0 = automatic");
    v("min_line_length", min_line_length, "m", "shorter feature lines are ignored");
  }
};

/// Hidden-line removal.
struct VisibilityParameters {
  double cell_size = 0;
  int cache_cells = 4096;
  double occlusion_tolerance = 0;
  bool exact = false;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("cell_size", cell_size, "m",
      "camera positions in one cell share the visible set; 0 = automatic");
    v("cache_cells", cache_cells, "", "cells kept before the least recently used one is dropped");
    v("occlusion_tolerance", occlusion_tolerance, "m",
      "a surface this close to a sample does not hide it; 0 = automatic");
    v("exact", exact, "", "cast rays for every pose instead of every cell (slow, for reference)");
  }
};

/// Edges of the camera image and the table made from them.
struct ImageParameters {
  double blur_sigma = 1.0;
  double edge_share = 0.08;
  double noise_factor = 4.0;
  double hysteresis = 0.4;
  bool straight_segments = false;
  double min_segment_length = 20;
  int mask_dilation = 5;
  int orientation_bins = 12;
  double orientation_tolerance_deg = 20;
  int search_length = 24;
  int clutter_window = 88;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("blur_sigma", blur_sigma, "px", "Gaussian smoothing before the gradient");
    v("edge_share", edge_share, "", "share of pixels whose gradient may start an edge");
    v("noise_factor", noise_factor, "", "edges must exceed the image noise by this factor");
    v("hysteresis", hysteresis, "", "weak threshold as a fraction of the strong one");
    v("straight_segments", straight_segments, "", "keep only edges that support straight segments");
    v("min_segment_length", min_segment_length, "px", "shortest straight segment");
    v("mask_dilation", mask_dilation, "px", "growth of the ignore mask");
    v("orientation_bins", orientation_bins, "", "edge directions told apart in the table");
    v("orientation_tolerance_deg", orientation_tolerance_deg, "deg",
      "largest angle between a model edge and the image edge it is matched to");
    v("search_length", search_length, "px", "longest normal; farther edges count as none");
    v("clutter_window", clutter_window, "px",
      "side of the window in which the density of edges is measured (robust model)");
  }
};

enum class LikelihoodModel { kPaper, kRobust };

/// What poses are compared with.
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
    v("cues", cues, "", "edges of camera images, depth images, or both");
    v("model", model, "", "paper (equations 1-3) or robust (log-ratio against no model edge)");
    v("sigma", sigma, "px", "standard deviation of the distance along the normal, eq. (1)");
    v("alpha", alpha, "", "factor of eq. (3), paper model");
    v("k", k, "", "exponent of eq. (3), paper model");
    v("missing_edge", missing_edge, "",
      "robust model: probability that a visible model edge leaves no edge in the image");
    v("line_saturation", line_saturation, "samples",
      "robust model: samples of one line count as at most this many independent ones");
    v("correlation_length", correlation_length, "px",
      "robust model: samples of a line closer than this in the image count partly");
    v("line_correlation", line_correlation, "",
      "robust model: correlation between lines; 0 adds them up, 1 averages them as eq. (3) does");
    v("scale", scale, "", "robust model: factor on the log-likelihood, see line_correlation");
    v("border_fade", border_fade, "px", "samples fade in over this distance from the image border");
    v("max_samples", max_samples, "",
      "samples per particle and image in the filter's updates; more are thinned out evenly; 0 = "
      "all");
    v("backend", backend, "", "what computes it: cpu, cuda, or auto: cuda where a device answers");
  }
};

/// Depth images against the model's surfaces, see docs/likelihood.md.
struct DepthParameters {
  double truncation = 0.3;
  double voxel_size = 0;
  bool store_field = true;
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
    v("truncation", truncation, "m", "points farther from every surface than this are clutter");
    v("voxel_size", voxel_size, "m",
      "grid of the distance field; 0 = automatic: 4 cm, more where memory asks for it");
    v("store_field", store_field, "",
      "keep the distance field on disk, beside the model or in the user's cache directory");
    v("points", points, "", "points taken from a depth image");
    v("min_range", min_range, "m", "smaller depths are not used");
    v("max_range", max_range, "m", "larger depths are not used");
    v("sigma", sigma, "m", "standard deviation of a point's distance from its surface, at range 0");
    v("sigma_per_square_metre", sigma_per_square_metre, "m/m^2",
      "what the noise of a depth adds, times the square of the depth");
    v("bias_sigma", bias_sigma, "1/m",
      "what is not known of the sensor's calibration: standard deviation of b in an error b z^2, "
      "which the filter learns as it tracks; 0 = none");
    v("clutter", clutter, "", "probability that a point is not on the model");
    v("independent_points", independent_points, "",
      "all points of an image together count as so many independent ones");
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
    v("enabled", enabled, "", "refine the best particles and draw particles from the result");
    v("iterations", iterations, "", "Gauss-Newton steps");
    v("search_length", search_length, "px", "length of the normals at the first step");
    v("final_search_length", final_search_length, "px", "length of the normals at the last step");
    v("sigma", sigma, "px", "noise of an edge along its normal");
    v("starts", starts, "", "particles from which refinement starts");
    v("max_samples", max_samples, "", "samples used per camera; more are thinned out evenly");
    v("start_iterations", start_iterations, "",
      "Gauss-Newton steps from each of the `starts`, whose results only guide particles");
    v("start_samples", start_samples, "", "samples used there");
  }
};

/// The particle filter.
struct FilterParameters {
  int particles = 1000;
  uint64_t seed = 1;
  double odometry_noise_position = 0.01;
  double odometry_noise_angle_deg = 0.3;
  double odometry_noise_per_metre = 0.04;
  double odometry_noise_per_radian = 0.04;
  double walk_position_rate = 0.03;
  double walk_angle_rate_deg = 3;
  double walk_acceleration = 1;
  double walk_angular_acceleration_deg = 60;
  double velocity_smoothing = 0.6;
  double resample_threshold = 0.5;
  double ess_floor = 0.1;
  double refined_share = 0.3;
  double tail_share = 0.1;
  double tail_scale = 4;
  int max_passes = 5;
  double recovery_alpha_slow = 0;
  double recovery_alpha_fast = 0;
  double recovery_std_position = 0.3;
  double recovery_std_angle_deg = 8;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("particles", particles, "", "number of hypotheses");
    v("seed", seed, "", "seed of the random generator");
    v("odometry_noise_position", odometry_noise_position, "m/sqrt(0.1 s)",
      "odometry: position noise per step, grows with the root of its duration");
    v("odometry_noise_angle_deg", odometry_noise_angle_deg, "deg/sqrt(0.1 s)",
      "odometry: rotation noise per step, grows with the root of its duration");
    v("odometry_noise_per_metre", odometry_noise_per_metre, "m/m",
      "odometry: position noise by distance");
    v("odometry_noise_per_radian", odometry_noise_per_radian, "rad/rad",
      "odometry: rotation noise by angle");
    v("walk_position_rate", walk_position_rate, "m/sqrt(s)", "without odometry: position noise");
    v("walk_angle_rate_deg", walk_angle_rate_deg, "deg/sqrt(s)",
      "without odometry: rotation noise");
    v("walk_acceleration", walk_acceleration, "m/s^2",
      "without odometry: acceleration that the constant-velocity model misses");
    v("walk_angular_acceleration_deg", walk_angular_acceleration_deg, "deg/s^2",
      "without odometry: angular acceleration that the constant-velocity model misses");
    v("velocity_smoothing", velocity_smoothing, "",
      "without odometry: share of the newest velocity in the constant-velocity model");
    v("resample_threshold", resample_threshold, "", "resample when ESS/N falls below");
    v("ess_floor", ess_floor, "", "an image is tempered so that ESS/N stays above this");
    v("refined_share", refined_share, "", "share of particles drawn from refined poses");
    v("tail_share", tail_share, "", "share of particles predicted with a wider spread");
    v("tail_scale", tail_scale, "", "how much wider");
    v("max_passes", max_passes, "",
      "an image is used in up to so many tempered passes while the particles spread wider than "
      "the normals of the refinement reach");
    v("recovery_alpha_slow", recovery_alpha_slow, "",
      "weight of an image in the slow average of the likelihood per line; particles are injected "
      "in proportion as the fast average falls below the slow one; 0 = never");
    v("recovery_alpha_fast", recovery_alpha_fast, "", "likewise, in the fast average");
    v("recovery_std_position", recovery_std_position, "m",
      "injected particles are spread so much wider than motion explains, per axis");
    v("recovery_std_angle_deg", recovery_std_angle_deg, "deg", "likewise, rotation");
  }
};

/// Live tracking: which images are used, and when a pose is to be trusted.
struct TrackingParameters {
  double update_min_d = 0;
  double update_min_a_deg = 0;
  int min_visible_samples = 60;
  int min_edge_pixels = 100;
  double max_masked_share = 0.8;
  bool lift_mask = true;
  double min_match_ratio = 0.35;
  double min_evidence = 7;
  double min_depth_agreement = 0.4;
  double lost_after = 1.5;
  double converged_std_position = 0.1;
  double converged_std_angle_deg = 3;
  double max_gap = 1;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("update_min_d", update_min_d, "m",
      "images are used only after so much motion by odometry (or update_min_a_deg); 0 = always");
    v("update_min_a_deg", update_min_a_deg, "deg", "likewise, rotation");
    v("min_visible_samples", min_visible_samples, "",
      "an image in which the expected pose sees fewer samples of the model is not used");
    v("min_edge_pixels", min_edge_pixels, "",
      "an image with fewer edge pixels (dark, covered) is not used");
    v("max_masked_share", max_masked_share, "",
      "an image with a larger share of its pixels masked is not used");
    v("lift_mask", lift_mask, "",
      "while tracking, the mask is lifted along edges of the model that the image shows under it: "
      "what the map holds is not foreign");
    v("min_match_ratio", min_match_ratio, "",
      "below this share of samples with an image edge in reach a pose is not trusted");
    v("min_evidence", min_evidence, "nats",
      "robust model: likewise, below this mean log-ratio of the visible lines against chance");
    v("min_depth_agreement", min_depth_agreement, "",
      "likewise, below this share of depth points on the model");
    v("lost_after", lost_after, "s", "lost when no pose could be trusted for so long");
    v("converged_std_position", converged_std_position, "m",
      "tracking needs a standard deviation per axis below this");
    v("converged_std_angle_deg", converged_std_angle_deg, "deg", "likewise, rotation");
    v("max_gap", max_gap, "s",
      "the constant-velocity model is not continued for longer than this without an image");
  }
};

/// Looking for the pose in the whole model, or around where it was lost.
struct SearchParameters {
  bool recover = true;
  double clearance = 0.2;
  double enclosure = 0.7;
  double place_spacing = 0.4;
  int max_places = 6000;
  int headings = 48;
  int orientations = 300;
  double tilt_sigma_deg = 2;
  int small_width = 160;
  int refined = 3000;
  int hypotheses = 100;
  double keyframe_distance = 0.15;
  double keyframe_angle_deg = 6;
  double keyframe_period = 0.5;
  int window = 10;
  int min_keyframes = 4;
  double line_correlation = 0.1;
  double min_margin = 200;
  double min_evidence = 4;
  double min_match_ratio = 0.8;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("recover", recover, "", "look for the pose again when it is lost");
    v("clearance", clearance, "m", "the camera is at least so far from every surface");
    v("enclosure", enclosure, "",
      "inside a building: surfaces in at least this share of all directions; 0 = anywhere in the "
      "model's bounds");
    v("place_spacing", place_spacing, "m",
      "distance of the places that are tried; more where there would be more than max_places");
    v("max_places", max_places, "", "see place_spacing");
    v("headings", headings, "", "directions tried per place when roll and pitch are known");
    v("orientations", orientations, "",
      "orientations tried per place when they are not: a camera held more or less upright");
    v("tilt_sigma_deg", tilt_sigma_deg, "deg", "how well roll and pitch are known at least");
    v("small_width", small_width, "px",
      "width, at least, of the reduced image that all those poses are compared with first");
    v("refined", refined, "", "the best so many of them are refined in the reduced image");
    v("hypotheses", hypotheses, "", "at most so many are kept from keyframe to keyframe");
    v("keyframe_distance", keyframe_distance, "m",
      "an image counts as a new view after so much motion (or keyframe_angle_deg)");
    v("keyframe_angle_deg", keyframe_angle_deg, "deg", "likewise, rotation");
    v("keyframe_period", keyframe_period, "s", "likewise without odometry, time");
    v("window", window, "", "keyframes that hypotheses are judged by, the newest");
    v("min_keyframes", min_keyframes, "", "a pose is reported after at least so many keyframes");
    v("line_correlation", line_correlation, "",
      "as likelihood.line_correlation; low, so that poses that explain more of the image win");
    v("min_margin", min_margin, "nats",
      "and only when it explains them so much better than the next different one");
    v("min_evidence", min_evidence, "nats",
      "robust model: and its lines stand out from chance by this, mean over the keyframes");
    v("min_match_ratio", min_match_ratio, "",
      "where a smaller share of its samples has an image edge in reach, the margin must be larger, "
      "by "
      "the square of what is missing");
  }
};

/// Everything.
struct Parameters {
  MapParameters map;
  VisibilityParameters visibility;
  ImageParameters image;
  LikelihoodParameters likelihood;
  DepthParameters depth;
  RefinementParameters refinement;
  FilterParameters filter;
  TrackingParameters tracking;
  SearchParameters search;

  template <class Visitor>
  void visitGroups(Visitor&& v) {
    v("map", map);
    v("visibility", visibility);
    v("image", image);
    v("likelihood", likelihood);
    v("depth", depth);
    v("refinement", refinement);
    v("filter", filter);
    v("tracking", tracking);
    v("search", search);
  }

  /// Lists every illegal value at once. @throws ParameterError
  void validate() const;

  /// Sets `group.name` from text. @throws ParameterError on an unknown name (with the nearest
  /// known one) or a value of the wrong type.
  void set(const std::string& dotted_name, const std::string& value);
  std::string get(const std::string& dotted_name) const;

  /// Reads a YAML file over the present values, then validates. @throws ParameterError listing
  /// all unknown keys and bad values; InputError when the file cannot be read.
  void loadYaml(const std::string& file);
  std::string toYaml() const;

  /// One entry per parameter, in order.
  struct Description {
    std::string name, unit, text, value;
  };
  std::vector<Description> describe() const;
};

/// The nearest of `known` by edit distance, for error messages.
std::string nearestName(const std::string& name, const std::vector<std::string>& known);

}  // namespace edge_mcl
