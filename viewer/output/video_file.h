/// Writes video files, checks that they are complete, and keeps them at their rate.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace cv {
class VideoWriter;
}

namespace edge_mcl {

/// A video file that is being written with FFmpeg through OpenCV.
class VideoFile {
 public:
  /// @param codecs codes of four characters; the first one that is installed is used. @param rate
  /// pictures per second. @throws InputError when the file cannot be written.
  VideoFile(std::string file, const std::vector<std::string>& codecs, double rate,
            const cv::Size& size);
  ~VideoFile();

  /// @param picture CV_8UC3 of the video's size.
  void write(const cv::Mat& picture);
  /// Completes the file. @throws InputError when the file does not hold all pictures, e.g. because
  /// the disk is full.
  void close();
  const std::string& name() const { return file_; }

 private:
  std::string file_;
  std::unique_ptr<cv::VideoWriter> writer_;
  int written_ = 0;
};

/// Keeps a video at its rate when pictures come at irregular times.
class VideoPace {
 public:
  /// @param rate pictures per second of the video. @param begin time of the first picture, s.
  VideoPace(double rate, double begin) : rate_(rate), begin_(begin) {}
  /// Returns how many copies of the picture of now (s) to write, so that the video lasts as long as
  /// the recording. The number is at most 250, so a long pause is shorter in the video.
  int copiesAt(double now);

 private:
  double rate_, begin_;
  double written_ = 0;
};

}  // namespace edge_mcl
