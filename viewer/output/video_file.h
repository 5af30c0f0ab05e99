/// Videos: written whole or not at all, and at their rate.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace cv {
class VideoWriter;
}

namespace edge_mcl {

class VideoFile {
 public:
  /// @param codecs four characters each; the first that there is. @throws InputError when it cannot
  /// be written.
  VideoFile(std::string file, const std::vector<std::string>& codecs, double rate,
            const cv::Size& size);
  ~VideoFile();

  /// @param picture CV_8UC3 of the video's size.
  void write(const cv::Mat& picture);
  /// @throws InputError when not all pictures are in the file, e.g. as the disk is full.
  void close();
  const std::string& name() const { return file_; }

 private:
  std::string file_;
  std::unique_ptr<cv::VideoWriter> writer_;
  int written_ = 0;
};

/// Keeps a video at its rate, however often there are pictures.
class VideoPace {
 public:
  /// @param begin s; of the first picture.
  VideoPace(double rate, double begin) : rate_(rate), begin_(begin) {}
  /// How often a picture must be written for the video to be as long as it took; after a long pause
  /// fewer, so that the video has the pause shortened.
  int copiesAt(double now);

 private:
  double rate_, begin_;
  double written_ = 0;
};

}  // namespace edge_mcl
