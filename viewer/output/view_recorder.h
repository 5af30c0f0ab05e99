/// Writes what the viewer shows: a video, pictures.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "edge_mcl/viewer/output/headless_view.h"

namespace edge_mcl {

/// What is written, and when.
struct RecorderOptions {
  std::string video;       ///< .mp4 or .avi; empty: none
  double video_rate = 10;  ///< pictures per second of the video
  std::string pictures;    ///< begin of the pictures' names: BEGIN-1.png, ...; empty: none
  std::vector<double> at;  ///< s since the first moment, increasing; empty: the last moment
};

class VideoFile;

class ViewRecorder {
 public:
  /// @throws InputError when the video cannot be written; ParameterError for a bad rate, an order
  /// or a kind of file.
  ViewRecorder(const LocalizationMap* map, const ViewParameters& params, RecorderOptions options);
  ~ViewRecorder();

  /// @throws InputError when something cannot be written.
  void show(const ViewMoment& moment);
  /// A model that comes later. It must outlive this object.
  void setMap(const LocalizationMap* map) { view_.setMap(map); }
  /// Whether this moment would be in a picture or the video.
  bool wants(const ViewMoment& moment) const;
  /// Completes the video, and writes the pictures that were not due yet, of the last moment.
  /// @throws InputError when not all of it could be written.
  void close();
  const std::vector<std::string>& written() const { return written_; }
  /// One line: moments, states, error where the truth is known.
  std::string summary() const;

 private:
  void writeNextPicture(const cv::Mat& picture);

  RecorderOptions options_;
  ViewParameters params_;
  ViewHistory history_;
  HeadlessView view_;
  std::unique_ptr<VideoFile> video_;
  ViewMoment last_;
  bool has_last_ = false;
  size_t next_picture_ = 0;
  size_t shown_ = 0;
  std::map<std::string, size_t> states_;
  std::vector<std::string> written_;
};

}  // namespace edge_mcl
