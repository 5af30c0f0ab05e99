/// Text on panels.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace edge_mcl::panel_text {

/// @param at left end of the base line. @return width, pixels.
int put(cv::Mat* panel, const std::string& text, cv::Point at, const cv::Scalar& color);
int widthOf(const std::string& text);

/// Dark on a box of its colour.
void label(cv::Mat* panel, const std::string& text, cv::Point at, const cv::Scalar& color);

/// Text of one colour.
struct Piece {
  std::string text;
  cv::Scalar color;
};
/// Pieces beside each other at the top left, on a dark ground.
void title(cv::Mat* panel, const std::vector<Piece>& pieces);

}  // namespace edge_mcl::panel_text
