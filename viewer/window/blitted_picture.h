/// A picture in a window of OpenGL's, without MRPT's textures.
#pragma once

#include <opencv2/core.hpp>

namespace edge_mcl {

/// One texture, filled again for every new picture and copied into the window. MRPT makes a new
/// texture for every image that it is given and keeps a record of each for ever (2.5.8), which
/// adds up where images change thirty times a second.
///
/// All methods but the constructor need the window's OpenGL context; what it holds goes with that.
class BlittedPicture {
 public:
  /// Shown from the next draw() on. @param picture CV_8UC3 (blue, green, red); empty: nothing.
  void set(const cv::Mat& picture, const cv::Rect& area);
  /// @param window_height pixels; areas count from the top.
  void draw(int window_height);

 private:
  cv::Mat picture_;
  cv::Rect area_;
  cv::Size loaded_;
  bool changed_ = false;
  unsigned texture_ = 0, framebuffer_ = 0;
};

}  // namespace edge_mcl
