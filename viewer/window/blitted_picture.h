/// Draws a picture into an OpenGL window without the textures of MRPT.
#pragma once

#include <opencv2/core.hpp>

namespace edge_mcl {

/// Uses one texture, fills it again for every new picture and copies it into the window. MRPT 2.5.8
/// would make a new texture for every image and would never free its record of it. Images change
/// about 30 times per second, so these records would add up.
///
/// draw() needs the window's OpenGL context. The texture ends with this context.
class BlittedPicture {
 public:
  /// Sets the picture for the next draw(). @param picture CV_8UC3 (blue, green, red) of the area's
  /// size; empty: nothing is drawn. @param area pixels of the window, from its top left.
  void set(const cv::Mat& picture, const cv::Rect& area);
  /// Draws the picture. @param window_height pixels.
  void draw(int window_height);

 private:
  cv::Mat picture_;
  cv::Rect area_;
  cv::Size loaded_;
  bool changed_ = false;
  unsigned texture_ = 0, framebuffer_ = 0;
};

}  // namespace edge_mcl
