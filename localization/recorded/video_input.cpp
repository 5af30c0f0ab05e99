#include "edge_mcl/localization/recorded/video_input.h"

#include <algorithm>
#include <cmath>
#include <opencv2/videoio.hpp>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

struct VideoInput::Impl {
  std::string file;
  CameraModel camera;
  cv::VideoCapture video;
  double rate = 0;  // Hz
  size_t count = 0, read = 0;
  bool has_ended = false;
  double first = 0, last = 0;  // s, as the file states it; of the image read last
};

VideoInput::VideoInput(const std::string& file, const CameraModel& camera)
    : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  impl_->camera = camera;
  try {
    impl_->video.open(file);
  } catch (const cv::Exception&) {
    // isOpened() tells it.
  }
  if (!impl_->video.isOpened())
    throw InputError(file + ": cannot be read as a video; `ffmpeg -i " + file +
                     " frames/%06d.png` makes images of it, if it is one");
  constexpr double kUsualRate = 30;  // Hz, of a file that states none
  const double rate = impl_->video.get(cv::CAP_PROP_FPS);
  impl_->rate = std::isfinite(rate) && rate > 0 ? rate : kUsualRate;
  impl_->count = static_cast<size_t>(std::max(0.0, impl_->video.get(cv::CAP_PROP_FRAME_COUNT)));
}

VideoInput::~VideoInput() = default;

size_t VideoInput::imageCount() const { return std::max(impl_->count, impl_->read); }

std::string VideoInput::damage() const {
  // Some files state one image more than they have.
  if (!impl_->has_ended || impl_->read + 1 >= impl_->count) return {};
  return impl_->file + ": " + std::to_string(impl_->read) + " of " + std::to_string(impl_->count) +
         " images could be read; the video is damaged or cut off";
}

bool VideoInput::next(LiveInput* input, std::string* problem) {
  Impl& m = *impl_;
  *input = {};
  problem->clear();
  cv::Mat image;
  try {
    m.has_ended = !m.video.read(image) || image.empty();
  } catch (const cv::Exception&) {
    m.has_ended = true;
  }
  if (m.has_ended) return false;
  // Some decoders begin at 0 and others at one image, and some files state no times.
  const double stated = m.video.get(cv::CAP_PROP_POS_MSEC) / 1000;
  if (m.read++ == 0) m.first = stated;
  const double since = stated - m.first;
  input->time =
      m.read == 1 ? 0 : (std::isfinite(since) && since > m.last ? since : m.last + 1 / m.rate);
  m.last = input->time;
  LiveInput::CameraImage view;
  view.camera = m.camera;
  view.origin = m.file + " at " + std::to_string(input->time) + " s";
  if (image.cols != m.camera.width || image.rows != m.camera.height) {
    *problem = view.origin + ": " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
               " pixels, the calibration says " + std::to_string(m.camera.width) + "x" +
               std::to_string(m.camera.height);
    return true;
  }
  view.image = image.clone();  // the decoder reuses its picture
  input->images.push_back(std::move(view));
  return true;
}

}  // namespace edge_mcl
