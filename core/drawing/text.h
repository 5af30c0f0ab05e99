/// Draws text into pictures.
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace edge_mcl {

enum class TextAnchor { kLeft, kCentre, kRight };

/// Draws a text with the font DejaVu Sans, or with OpenCV's stroke font where DejaVu is not
/// installed. The environment variable EDGE_MCL_FONT names another font file. Thread-safe.
/// @param picture CV_8UC3
/// @param at point of the base line to which the anchor refers, pixels
/// @param height of the font, pixels; a capital letter is some 70 % of it
/// @return width of the text, pixels
int drawText(cv::Mat* picture, const std::string& text, cv::Point at, const cv::Scalar& colour,
             int height, TextAnchor anchor = TextAnchor::kLeft);

/// Size of the text above the base line, pixels.
cv::Size textSize(const std::string& text, int height);

}  // namespace edge_mcl
