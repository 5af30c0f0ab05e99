/// What `edge-mcl localize` collects and reports: one schema for directories, bags and rawlogs.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "apps/recordings/recording_options.h"
#include "edge_mcl/core/recordings/text_table.h"
#include "edge_mcl/localization/recorded/recorded_localizer.h"

namespace edge_mcl {

class LocalizeReport {
 public:
  /// Adds the moment that the localizer has just processed.
  /// @param time_text the moment's stamp, as it is written to the trajectory
  void add(const RecordedLocalizer& localizer, const std::string& time_text);

  /// Summary over all moments so far; the recording's ground truth gives the errors.
  nlohmann::json summary(const OpenedRecording& opened, const RecordedInput& recording) const;
  /// One entry per image.
  const nlohmann::json& images() const { return images_; }
  /// Poses of the moments at which there was one.
  const Trajectory& estimate() const { return estimate_; }
  size_t unusableImages() const { return unusable_; }
  bool hasOdometry() const { return with_odometry_ > 0; }

 private:
  nlohmann::json images_ = nlohmann::json::array();
  Trajectory estimate_;
  std::map<std::string, size_t> states_;
  std::vector<double> update_ms_, image_times_;
  size_t unusable_ = 0, with_odometry_ = 0;
  // Images with masks by depth, those of them whose depth agrees with the model, sum of the shares.
  size_t with_foreign_ = 0, agreeing_ = 0;
  double foreign_share_ = 0;
  std::set<int> objects_;  // numbers of the objects that are not in the model
};

/// The summary as text for the terminal, several lines.
std::string textOfSummary(const nlohmann::json& summary);

}  // namespace edge_mcl
