/// Pictures written so that a file with its name is always whole.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace edge_mcl {

/// Writes a picture in the format of the file's ending: beside its place first, then renamed, so
/// that whoever waits for the file never reads half of it.
/// @param options pairs as in cv::imwrite.
/// @throw InputError naming the file when it cannot be written or its ending names no format.
void writePicture(const std::string& file, const cv::Mat& picture,
                  const std::vector<int>& options = {});

}  // namespace edge_mcl
