/// Parameters of the particle filter, the states and the search.
///
/// Every struct lists its fields once, in `visit`, with unit, range and meaning. Reading, checking,
/// printing and the documentation use that list.
#pragma once

#include <cstdint>

#include "edge_mcl/core/base/parameter_range.h"

namespace edge_mcl {

/// The particle filter.
struct FilterParameters {
  int particles = 1000;
  uint64_t seed = 1;
  double odometry_noise_position = 0.01;
  double odometry_noise_angle_deg = 0.3;
  double odometry_noise_per_metre = 0.04;
  double odometry_noise_per_radian = 0.04;
  bool learn_odometry = true;
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
    v("particles", particles, "", from(1, 10000000), "number of hypotheses");
    v("seed", seed, "", anyValue(), "seed of the random generator");
    v("odometry_noise_position", odometry_noise_position, "m/sqrt(0.1 s)", notNegative(),
      "with odometry: position noise of a step; it grows with the root of the step's duration");
    v("odometry_noise_angle_deg", odometry_noise_angle_deg, "deg/sqrt(0.1 s)", notNegative(),
      "with odometry: rotation noise of a step; it grows with the root of the step's duration");
    v("odometry_noise_per_metre", odometry_noise_per_metre, "m/sqrt(m)", notNegative(),
      "with odometry: position noise of one metre moved; it grows with the root of the distance");
    v("odometry_noise_per_radian", odometry_noise_per_radian, "rad/sqrt(rad)", notNegative(),
      "with odometry: rotation noise of one radian turned; it grows with the root of the angle");
    v("learn_odometry", learn_odometry, "", anyValue(),
      "while poses are trusted, scale and turn rate of the odometry and a factor on its noise are "
      "learnt");
    v("walk_position_rate", walk_position_rate, "m/sqrt(s)", positive(),
      "without odometry: position noise");
    v("walk_angle_rate_deg", walk_angle_rate_deg, "deg/sqrt(s)", positive(),
      "without odometry: rotation noise");
    v("walk_acceleration", walk_acceleration, "m/s^2", notNegative(),
      "without odometry: acceleration that the constant-velocity model does not know of");
    v("walk_angular_acceleration_deg", walk_angular_acceleration_deg, "deg/s^2", notNegative(),
      "without odometry: angular acceleration that the constant-velocity model does not know of");
    v("velocity_smoothing", velocity_smoothing, "", from(0, 1),
      "weight of the newest motion in the velocity that is kept for a time without odometry");
    v("resample_threshold", resample_threshold, "", from(0, 1),
      "particles are resampled when ESS/N (effective sample size over particles) is below this");
    v("ess_floor", ess_floor, "", between(0, 1),
      "the likelihood of an image is flattened (tempered) until ESS/N is above this");
    v("refined_share", refined_share, "", below(0, 1),
      "share of particles drawn from refined poses");
    v("tail_share", tail_share, "", below(0, 1),
      "share of particles predicted with a wider spread");
    v("tail_scale", tail_scale, "", from(1, 100), "factor on the spread of those particles");
    v("max_passes", max_passes, "", from(1, 100),
      "an image is used in up to this many tempered passes while the particles spread wider than "
      "the normals of the refinement reach");
    v("recovery_alpha_slow", recovery_alpha_slow, "", from(0, 1),
      "weight of an image in the slow average of the likelihood per line; particles are injected "
      "in proportion as the fast average falls below the slow one; 0 = never");
    v("recovery_alpha_fast", recovery_alpha_fast, "", from(0, 1),
      "weight of an image in the fast average");
    v("recovery_std_position", recovery_std_position, "m", positive(),
      "position spread of injected particles beyond what motion explains, per axis");
    v("recovery_std_angle_deg", recovery_std_angle_deg, "deg", positive(),
      "rotation spread of injected particles beyond what motion explains, per axis");
  }
};

/// Live tracking: which images are used, and when a pose is trusted.
struct TrackingParameters {
  double update_min_d = 0;
  double update_min_a_deg = 0;
  int min_visible_samples = 60;
  int min_edge_pixels = 100;
  double max_masked_share = 0.8;
  bool lift_mask = true;
  bool mask_by_depth = false;
  double mask_by_depth_from = 0.1;
  double min_probability = 0.8;
  double keep_probability = 0.5;
  double lost_probability = 0.4;
  double min_match_ratio = 0.1;
  double min_evidence = 0;
  double min_depth_agreement = 0.4;
  double lost_after = 1.5;
  double converged_std_position = 0.1;
  double converged_std_angle_deg = 3;
  double max_gap = 1;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("update_min_d", update_min_d, "m", notNegative(),
      "an image is used only after this much motion by odometry, or the rotation "
      "update_min_a_deg; 0 = every image is used");
    v("update_min_a_deg", update_min_a_deg, "deg", notNegative(),
      "an image is used only after this much rotation by odometry, or the motion update_min_d");
    v("min_visible_samples", min_visible_samples, "", notNegative(),
      "an image is not used when the expected pose sees fewer samples of the model in it");
    v("min_edge_pixels", min_edge_pixels, "", notNegative(),
      "an image with fewer edge pixels (dark, covered) is not used");
    v("max_masked_share", max_masked_share, "", from(0, 1),
      "an image with a larger share of its pixels masked is not used");
    v("lift_mask", lift_mask, "", anyValue(),
      "while tracking, the mask is removed along model edges that the images show under it");
    v("mask_by_depth", mask_by_depth, "", anyValue(),
      "while the pose is likely, what a depth camera sees in front of the model is masked in the "
      "images");
    v("mask_by_depth_from", mask_by_depth_from, "m", positive(),
      "smallest distance of such a thing from the model; depth noise and the uncertainty of the "
      "pose are added");
    v("min_probability", min_probability, "", from(0, 1),
      "a pose is trusted when the probability that it is within 0.25 m and 5 degrees is at least "
      "this");
    v("keep_probability", keep_probability, "", from(0, 1),
      "a trusted pose stays trusted while that probability is at least this");
    v("lost_probability", lost_probability, "", from(0, 1),
      "a pose above this probability is lost only after four times lost_after");
    v("min_match_ratio", min_match_ratio, "", from(0, 1),
      "a pose is not trusted when a smaller share of its samples has an image edge in reach");
    v("min_evidence", min_evidence, "nats", anyValue(),
      "robust model: a pose is not trusted when the mean log-ratio of its visible lines against "
      "chance is smaller");
    v("min_depth_agreement", min_depth_agreement, "", from(0, 1),
      "a pose is not trusted when a smaller share of the depth points lies on the model");
    v("lost_after", lost_after, "s", notNegative(),
      "the state is lost when no pose could be trusted for this long");
    v("converged_std_position", converged_std_position, "m", positive(),
      "tracking needs a standard deviation of the position below this, per axis");
    v("converged_std_angle_deg", converged_std_angle_deg, "deg", positive(),
      "tracking needs a standard deviation of the rotation below this, per axis");
    v("max_gap", max_gap, "s", positive(),
      "the constant-velocity model is continued for at most this long without an image");
  }
};

/// Search for the pose in the whole model, or around the place where it was lost.
struct SearchParameters {
  bool recover = true;
  double clearance = 0.2;
  double enclosure = 0.7;
  double place_spacing = 0.4;
  int max_places = 6000;
  bool prepared = true;
  double prepared_spacing = 0.4;
  double prepared_megabytes = 400;
  bool store_places = true;
  int candidates = 800;
  int headings = 48;
  int orientations = 300;
  double tilt_sigma_deg = 2;
  int small_width = 160;
  int refined = 3000;
  int hypotheses = 100;
  double keyframe_distance = 0.08;
  double keyframe_angle_deg = 4;
  double keyframe_period = 0.5;
  double glance_period = 0.06;
  int window = 10;
  int min_keyframes = 3;
  double line_correlation = 0.1;
  double min_margin = 200;
  double min_evidence = 4;
  double min_match_ratio = 0.8;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("recover", recover, "", anyValue(), "a search starts when the pose is lost");
    v("clearance", clearance, "m", notNegative(),
      "places nearer to a surface than this are not tried");
    v("enclosure", enclosure, "", from(0, 1),
      "a place is inside the building when surfaces lie in at least this share of all directions; "
      "0 = every place within the model's bounds is tried");
    v("place_spacing", place_spacing, "m", positive(),
      "distance between the places that are tried; it grows where there would be more than "
      "max_places");
    v("max_places", max_places, "", from(1, 1000000), "largest number of places that are tried");
    v("prepared", prepared, "", anyValue(),
      "what places see is prepared once for a building with right angles, so that a search of the "
      "whole model takes about a second");
    v("prepared_spacing", prepared_spacing, "m", from(0.1, 10),
      "distance between prepared places; it grows where they would need more than "
      "prepared_megabytes");
    v("prepared_megabytes", prepared_megabytes, "MB", from(1, 100000),
      "most memory for prepared places");
    v("store_places", store_places, "", anyValue(),
      "prepared places are kept on disk, beside the model or in the user's cache directory");
    v("candidates", candidates, "", from(10, 1000000),
      "number of the best poses at prepared places that are refined in the reduced image");
    v("headings", headings, "", from(1, 10000),
      "directions tried per place when roll and pitch are known");
    v("orientations", orientations, "", from(1, 100000),
      "orientations tried per place when roll and pitch are not known; the camera is assumed to be "
      "held roughly upright");
    v("tilt_sigma_deg", tilt_sigma_deg, "deg", positive(),
      "smallest standard deviation that is assumed for known roll and pitch");
    v("small_width", small_width, "px", atLeast(80),
      "smallest width of the reduced image with which all those poses are compared first");
    v("refined", refined, "", atLeast(1),
      "number of the best poses that are refined in the reduced image");
    v("hypotheses", hypotheses, "", atLeast(2),
      "largest number of poses that are kept from keyframe to keyframe");
    v("keyframe_distance", keyframe_distance, "m", notNegative(),
      "an image becomes a keyframe after this much motion, or the rotation keyframe_angle_deg");
    v("keyframe_angle_deg", keyframe_angle_deg, "deg", notNegative(),
      "an image becomes a keyframe after this much rotation, or the motion keyframe_distance");
    v("keyframe_period", keyframe_period, "s", notNegative(),
      "without odometry an image becomes a keyframe after this time at the latest");
    v("glance_period", glance_period, "s", notNegative(),
      "without odometry hypotheses are followed through an image after this time; it becomes a "
      "keyframe when most of them have moved as far as keyframe_distance or keyframe_angle_deg");
    v("window", window, "", from(2, 1000),
      "number of the newest keyframes by which hypotheses are judged");
    v("min_keyframes", min_keyframes, "", atLeast(1),
      "a pose is reported after at least this many keyframes");
    v("line_correlation", line_correlation, "", from(0, 1),
      "as likelihood.line_correlation; it is low so that poses that explain more of the image win");
    v("min_margin", min_margin, "nats", notNegative(),
      "a pose is reported only when its log-likelihood exceeds that of the next different pose by "
      "this");
    v("min_evidence", min_evidence, "nats", anyValue(),
      "robust model: a pose is reported only when the log-ratio of its lines against chance, "
      "averaged over the keyframes, is at least this");
    v("min_match_ratio", min_match_ratio, "", from(0, 1),
      "where a smaller share of the samples has an image edge in reach, min_margin grows by the "
      "square of the ratio of the two shares");
  }
};

}  // namespace edge_mcl
