/// What the localizer tells on /diagnostics: the pose, the images and the motion, each by itself.
#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <optional>
#include <string>

#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

/// The newest image and what the localizer made of it.
struct LocalizerFacts {
  LiveResult result;
  std::string backend;  ///< device that computes the likelihood
  double silence = -1;  ///< time since the newest image, s; negative: there was none
  double update_ms = 0;
  uint32_t images_received = 0, images_dropped = 0;
  double mask_age = -1;        ///< s; negative: no mask
  bool wants_odometry = true;  ///< the parameter `odometry` is not none
  bool has_odometry = false;
  bool has_up = false;  ///< roll and pitch from an IMU
};

/// OK: the pose is tracked. ERROR: it is lost. WARN: in between, or no image comes.
void diagnosePose(const LocalizerFacts& facts, diagnostic_updater::DiagnosticStatusWrapper* status);
/// WARN: no image comes, the newest was not used, or more than half of them are dropped.
void diagnoseImages(const LocalizerFacts& facts,
                    diagnostic_updater::DiagnosticStatusWrapper* status);
/// WARN: odometry is missing, so that motion is guessed from the poses.
void diagnoseMotion(const LocalizerFacts& facts,
                    diagnostic_updater::DiagnosticStatusWrapper* status);

}  // namespace edge_mcl
