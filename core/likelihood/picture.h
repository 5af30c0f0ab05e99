/// A camera picture whose score table is made where it is needed, on a device or on the CPU.
#pragma once

#include <memory>
#include <mutex>
#include <opencv2/core.hpp>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/likelihood/score_levels.h"
#include "edge_mcl/core/likelihood/score_table.h"

namespace edge_mcl {

/// Grey picture and mask of one image. The score table can be made from it.
class Picture {
 public:
  /// @param grey CV_8U. @param ignore see ignoredPixels(); empty: no mask.
  Picture(cv::Mat grey, cv::Mat ignore, const ImageParameters& params,
          std::shared_ptr<const ScoreLevels> levels);

  const cv::Mat& grey() const { return grey_; }
  const cv::Mat& ignore() const { return ignore_; }
  const ImageParameters& params() const { return params_; }
  const std::shared_ptr<const ScoreLevels>& levels() const { return levels_; }
  /// Score table. The CPU makes it at the first call. Thread-safe.
  std::shared_ptr<const ScoreTable> table() const;

 private:
  cv::Mat grey_, ignore_;
  ImageParameters params_;
  std::shared_ptr<const ScoreLevels> levels_;
  mutable std::once_flag made_;
  mutable std::shared_ptr<const ScoreTable> table_;
};

}  // namespace edge_mcl
