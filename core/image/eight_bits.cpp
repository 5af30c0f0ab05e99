#include "edge_mcl/core/image/eight_bits.h"

#include <array>

namespace edge_mcl {

namespace {

/// Number of bits of a value, 8 to 16.
int bitsOf(uint16_t value) {
  int bits = 8;
  while (bits < 16 && value >> bits != 0) ++bits;
  return bits;
}

/// Number of bits that hold all but the largest thousandth of the values.
int usedBits(const cv::Mat& image) {
  std::array<size_t, 17> count{};  // values with this number of bits
  const int row = image.cols * image.channels();
  for (int y = 0; y < image.rows; ++y) {
    const auto* values = image.ptr<uint16_t>(y);
    for (int x = 0; x < row; ++x) ++count[static_cast<size_t>(bitsOf(values[x]))];
  }
  size_t most = image.total() * static_cast<size_t>(image.channels()) / 1000;
  int bits = 16;
  while (bits > 8 && count[static_cast<size_t>(bits)] <= most) {
    most -= count[static_cast<size_t>(bits)];
    --bits;
  }
  return bits;
}

}  // namespace

cv::Mat toEightBits(const cv::Mat& image) {
  if (image.depth() != CV_16U) return image;
  cv::Mat eight;
  image.convertTo(eight, CV_8U, 1.0 / (1 << (usedBits(image) - 8)));
  return eight;
}

}  // namespace edge_mcl
