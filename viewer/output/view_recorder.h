/// Writes the viewer's picture to a video and to picture files.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "edge_mcl/viewer/output/headless_view.h"

namespace edge_mcl {

/// Which files the recorder writes, and when.
struct RecorderOptions {
  std::string video;       ///< .mp4 or .avi; empty: none
  double video_rate = 10;  ///< pictures per second of the video
  std::string pictures;    ///< begin of the file names: BEGIN-1.png, ...; empty: no pictures
  std::vector<double> at;  ///< times of the pictures, s since the first moment, increasing; empty:
                           ///< one picture of the last moment
};

class VideoFile;

/// Draws moments without a window and writes them.
class ViewRecorder {
 public:
  /// @param map may be null; otherwise it must outlive this object. @throws InputError when the
  /// video cannot be written; ParameterError for a bad rate, times that do not increase or an
  /// unknown kind of file.
  ViewRecorder(const LocalizationMap* map, const ViewParameters& params, RecorderOptions options);
  ~ViewRecorder();

  /// Adds a moment, and draws and writes it when it is wanted. @throws InputError when a file
  /// cannot be written.
  void show(const ViewMoment& moment);
  /// Sets the model when it comes later. It must outlive this object.
  void setMap(const LocalizationMap* map) { view_.setMap(map); }
  /// Whether this moment goes into a picture or the video.
  bool wants(const ViewMoment& moment) const;
  /// Completes the video. Pictures that were not due yet are written now and show the last moment.
  /// @throws InputError when a file could not be written in full.
  void close();
  /// Names of all files written.
  const std::vector<std::string>& written() const { return written_; }
  /// One line of text: number of moments, states, and the error if ground truth is known.
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
