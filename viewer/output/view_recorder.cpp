#include "edge_mcl/viewer/output/view_recorder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"
#include "edge_mcl/viewer/output/video_file.h"

namespace edge_mcl {

namespace {

bool endsWith(const std::string& text, const std::string& ending) {
  return text.size() > ending.size() &&
         text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

std::vector<std::string> codecsFor(const std::string& file) {
  // H.264 first, because browsers play it; it needs an installed encoder.
  if (endsWith(file, ".mp4")) return {"avc1", "mp4v"};
  if (endsWith(file, ".avi")) return {"MJPG"};
  throw ParameterError(file + ": .mp4 or .avi expected");
}

}  // namespace

ViewRecorder::ViewRecorder(const LocalizationMap* map, const ViewParameters& params,
                           RecorderOptions options)
    : options_(std::move(options)), params_(params), view_(map, params) {
  if (!(options_.video_rate > 0) || options_.video_rate > 1000)
    throw ParameterError("video rate: above 0, at most 1000 pictures per second expected");
  if (!std::is_sorted(options_.at.begin(), options_.at.end()))
    throw ParameterError("pictures: times must increase");
  if (options_.at.empty() && !options_.pictures.empty())
    options_.at = {std::numeric_limits<double>::infinity()};
  if (options_.video.empty()) return;
  video_ = std::make_unique<VideoFile>(options_.video, codecsFor(options_.video),
                                       options_.video_rate, cv::Size(params.width, params.height));
  written_.push_back(options_.video);
}

ViewRecorder::~ViewRecorder() = default;

bool ViewRecorder::wants(const ViewMoment& moment) const {
  const bool due = !options_.pictures.empty() && next_picture_ < options_.at.size() &&
                   moment.elapsed >= options_.at[next_picture_];
  return due || video_;
}

void ViewRecorder::writeNextPicture(const cv::Mat& picture) {
  const std::string file = options_.pictures + "-" + std::to_string(++next_picture_) + ".png";
  writePicture(file, picture);
  written_.push_back(file);
}

void ViewRecorder::show(const ViewMoment& moment) {
  history_.add(moment);
  ++shown_;
  ++states_[nameOf(moment.state)];
  last_ = moment;
  has_last_ = true;
  if (!wants(moment)) return;
  const cv::Mat picture = view_.draw(moment, history_.view(history_.size(), params_.strip_seconds));
  while (!options_.pictures.empty() && next_picture_ < options_.at.size() &&
         moment.elapsed >= options_.at[next_picture_])
    writeNextPicture(picture);
  if (video_) video_->write(picture);
}

std::string ViewRecorder::summary() const {
  std::string text = std::to_string(shown_) + " moments:";
  for (const auto& [state, count] : states_) text += " " + state + " " + std::to_string(count);
  std::vector<double> position, angle;
  for (size_t i = 0; i < history_.size(); ++i) {
    if (!history_[i].error_position) continue;
    position.push_back(*history_[i].error_position);
    angle.push_back(*history_[i].error_angle_deg);
  }
  if (position.empty()) return text;
  char errors[128];
  std::snprintf(errors, sizeof errors, "; error: median %.1f cm, %.2f deg; 90 %% below %.1f cm",
                100 * summarize(position).median, summarize(angle).median,
                100 * summarize(position).p90);
  return text + errors;
}

void ViewRecorder::close() {
  if (video_) video_->close();
  video_.reset();
  if (!has_last_ || options_.pictures.empty()) return;
  while (next_picture_ < options_.at.size())
    writeNextPicture(view_.draw(last_, history_.view(history_.size(), params_.strip_seconds)));
}

}  // namespace edge_mcl
