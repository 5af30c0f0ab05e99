/// Brings images of 16 bits to 8 bits.
#pragma once

#include <opencv2/core.hpp>

namespace edge_mcl {

/// Converts an image of any depth and number of channels to 8 bits. Cameras of 10, 12 or 14 bits
/// write their values into 16 bits without a shift. So the number of bits that the image uses
/// decides: all but the brightest thousandth of the values keep their order. Images of 8 bits are
/// returned as they are.
cv::Mat toEightBits(const cv::Mat& image);

}  // namespace edge_mcl
