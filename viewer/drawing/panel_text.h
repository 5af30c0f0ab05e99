/// Draws text on the panels of the viewer.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace edge_mcl::panel_text {

/// Draws a text. @param panel CV_8UC3. @param at left end of the base line, pixels.
/// @return width of the text, pixels.
int put(cv::Mat* panel, const std::string& text, cv::Point at, const cv::Scalar& color);
/// Width of a text, pixels.
int widthOf(const std::string& text);

/// Draws dark text on a filled box. @param at as for put(). @param color of the box.
void label(cv::Mat* panel, const std::string& text, cv::Point at, const cv::Scalar& color);

/// A part of a title, in one colour.
struct Piece {
  std::string text;
  cv::Scalar color;
};
/// Draws the pieces side by side at the top left of the panel, on a darkened ground.
void title(cv::Mat* panel, const std::vector<Piece>& pieces);

}  // namespace edge_mcl::panel_text
