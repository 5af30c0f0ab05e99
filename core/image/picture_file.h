/// Writes pictures so that a file with the final name is always complete.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace edge_mcl {

/// Whether the ending of a file name tells a format that writePicture() can write.
bool isPictureName(const std::string& file);
/// To be called before long work. @throws InputError when the ending names no format.
void requirePictureName(const std::string& file);

/// Writes a picture in the format that the ending of the file name tells. It writes FILE.part first
/// and renames it, so that a program that waits for the file never reads half of it.
/// @param options pairs as in cv::imwrite.
/// @throws InputError naming the file when it cannot be written or its ending names no format.
void writePicture(const std::string& file, const cv::Mat& picture,
                  const std::vector<int>& options = {});

}  // namespace edge_mcl
