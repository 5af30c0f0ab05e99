#include "edge_mcl/core/drawing/text.h"

#include <cstdlib>
#include <fstream>
#include <mutex>
#include <opencv2/imgproc.hpp>
#ifdef EDGE_MCL_HAS_FREETYPE
#include <opencv2/freetype.hpp>
#endif

namespace edge_mcl {

namespace {

/// At scale 1 the capital letters of the stroke font are 22 pixels high. Those of DejaVu have that
/// height at a font height of 30 pixels.
constexpr double kStrokeScale = 1 / 30.0;
constexpr int kStrokeFont = cv::FONT_HERSHEY_SIMPLEX;

#ifdef EDGE_MCL_HAS_FREETYPE
std::string fontFile() {
  if (const char* wanted = std::getenv("EDGE_MCL_FONT")) return wanted;
  return "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
}

/// Null where the font cannot be read.
cv::Ptr<cv::freetype::FreeType2> loadFont() {
  const std::string file = fontFile();
  if (!std::ifstream(file)) return nullptr;
  try {
    cv::Ptr<cv::freetype::FreeType2> font = cv::freetype::createFreeType2();
    font->loadFontData(file, 0);
    return font;
  } catch (const cv::Exception&) {
    return nullptr;
  }
}

const cv::Ptr<cv::freetype::FreeType2>& font() {
  static const cv::Ptr<cv::freetype::FreeType2> loaded = loadFont();
  return loaded;
}

/// The font renders glyphs into buffers of its own.
std::mutex& fontMutex() {
  static std::mutex mutex;
  return mutex;
}
#endif

}  // namespace

cv::Size textSize(const std::string& text, int height) {
  int base = 0;
#ifdef EDGE_MCL_HAS_FREETYPE
  if (font()) {
    const std::lock_guard<std::mutex> lock(fontMutex());
    return font()->getTextSize(text, height, -1, &base);
  }
#endif
  return cv::getTextSize(text, kStrokeFont, kStrokeScale * height, 1, &base);
}

int drawText(cv::Mat* picture, const std::string& text, cv::Point at, const cv::Scalar& colour,
             int height, TextAnchor anchor) {
  if (text.empty()) return 0;
  const int width = textSize(text, height).width;
  if (anchor == TextAnchor::kCentre) at.x -= width / 2;
  if (anchor == TextAnchor::kRight) at.x -= width;
#ifdef EDGE_MCL_HAS_FREETYPE
  if (font()) {
    const std::lock_guard<std::mutex> lock(fontMutex());
    font()->putText(*picture, text, at, height, colour, -1, cv::LINE_AA, true);
    return width;
  }
#endif
  cv::putText(*picture, text, at, kStrokeFont, kStrokeScale * height, colour, 1, cv::LINE_AA);
  return width;
}

}  // namespace edge_mcl
