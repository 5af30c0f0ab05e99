#include "edge_mcl/viewer/output/video_file.h"

#include <algorithm>
#include <cmath>
#include <opencv2/videoio.hpp>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

VideoFile::VideoFile(std::string file, const std::vector<std::string>& codecs, double rate,
                     const cv::Size& size)
    : file_(std::move(file)), writer_(std::make_unique<cv::VideoWriter>()) {
  for (const std::string& c : codecs)
    if (writer_->open(file_, cv::CAP_FFMPEG, cv::VideoWriter::fourcc(c[0], c[1], c[2], c[3]), rate,
                      size))
      return;
  throw InputError(file_ + ": the video cannot be written");
}

VideoFile::~VideoFile() = default;

void VideoFile::write(const cv::Mat& picture) {
  writer_->write(picture);
  ++written_;
}

void VideoFile::close() {
  writer_->release();
  if (written_ == 0) return;
  // The writer reports no errors, so the number of pictures in the file is checked.
  const cv::VideoCapture video(file_, cv::CAP_FFMPEG);
  if (!video.isOpened() || video.get(cv::CAP_PROP_FRAME_COUNT) < written_)
    throw InputError(file_ + ": the video cannot be written in full (is the disk full?)");
}

int VideoPace::copiesAt(double now) {
  constexpr double kMost = 250;
  const double due = std::floor((now - begin_) * rate_) + 1;
  const double copies = std::clamp(due - written_, 0.0, kMost);
  written_ = std::max(written_, due);
  return static_cast<int>(copies);
}

}  // namespace edge_mcl
