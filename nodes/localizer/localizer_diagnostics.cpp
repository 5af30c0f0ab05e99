#include "edge_mcl/nodes/localizer/localizer_diagnostics.h"

#include "edge_mcl/localization/tracking/localizer_state.h"

namespace edge_mcl {

namespace {

using Level = diagnostic_msgs::DiagnosticStatus;

constexpr double kSilent = 2;  // s without an image

/// Whether images come. Else the status says so.
bool hasImages(const LocalizerFacts& facts, diagnostic_updater::DiagnosticStatusWrapper* status) {
  if (facts.silence >= 0 && facts.silence <= kSilent) return true;
  status->summary(Level::WARN, facts.silence < 0 ? "no image yet" : "no more images");
  return false;
}

}  // namespace

void diagnosePose(const LocalizerFacts& facts,
                  diagnostic_updater::DiagnosticStatusWrapper* status) {
  const LiveResult& r = facts.result;
  const bool is_tracked = r.state == LocalizerState::kTracking && r.problem.empty();
  if (hasImages(facts, status)) {
    std::string summary = nameOf(r.state);
    if (r.state == LocalizerState::kSearching)
      summary += ", " + std::to_string(r.search_keyframes) + " keyframes used";
    if (r.state == LocalizerState::kLost)
      status->summary(Level::ERROR, summary);
    else
      status->summary(is_tracked ? Level::OK : Level::WARN, summary);
  }
  status->add("state", nameOf(r.state));
  status->add("problem", r.problem);
  status->add("probability", r.probability);
  status->add("match ratio", r.match_ratio);
  status->add("effective sample size", r.report.effective_sample_size);
  status->add("visible lines", r.report.visible_lines);
  status->add("keyframes of the search", r.search_keyframes);
  status->add("places of the search", r.clusters.size());
}

void diagnoseImages(const LocalizerFacts& facts,
                    diagnostic_updater::DiagnosticStatusWrapper* status) {
  const LiveResult& r = facts.result;
  if (hasImages(facts, status)) {
    if (!r.updated && !r.problem.empty())
      status->summary(Level::WARN, "the newest image was not used");
    else if (2 * facts.images_dropped > facts.images_received)
      status->summary(Level::WARN, "more images come than can be used");
    else
      status->summary(Level::OK, "images are used");
  }
  status->add("seconds since the last image", facts.silence);
  status->add("received", facts.images_received);
  status->add("dropped", facts.images_dropped);
  status->add("update ms", facts.update_ms);
  status->add("masked share", r.masked_share);
  status->add("mask age s", facts.mask_age);
  status->add("backend", facts.backend);
}

void diagnoseMotion(const LocalizerFacts& facts,
                    diagnostic_updater::DiagnosticStatusWrapper* status) {
  if (hasImages(facts, status)) {
    const int level = facts.has_odometry || !facts.wants_odometry ? Level::OK : Level::WARN;
    status->summary(static_cast<unsigned char>(level),
                    facts.has_odometry ? "odometry" : "motion is guessed from the poses");
  }
  const OdometryCalibration& learnt = facts.result.odometry;
  status->add("odometry", facts.has_odometry);
  status->add("roll and pitch of an IMU", facts.has_up);
  status->add("distances are longer by", learnt.scaleError());
  status->add("turn that odometry misses, rad/s", learnt.turnRate().norm());
  status->add("factor on the noise", learnt.noiseFactor());
}

}  // namespace edge_mcl
