/// A camera picture whose score table is made by whoever needs it, on a device or here.
#pragma once

#include <memory>
#include <mutex>
#include <opencv2/core.hpp>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/likelihood/score_levels.h"
#include "edge_mcl/core/likelihood/score_table.h"

namespace edge_mcl {

class Picture {
 public:
  /// @param grey CV_8U. @param ignore see ignoredPixels; empty for none.
  Picture(cv::Mat grey, cv::Mat ignore, const ImageParameters& params,
          std::shared_ptr<const ScoreLevels> levels);

  const cv::Mat& grey() const { return grey_; }
  const cv::Mat& ignore() const { return ignore_; }
  const ImageParameters& params() const { return params_; }
  const std::shared_ptr<const ScoreLevels>& levels() const { return levels_; }
  /// Made here with the first call. Thread-safe.
  std::shared_ptr<const ScoreTable> table() const;

 private:
  cv::Mat grey_, ignore_;
  ImageParameters params_;
  std::shared_ptr<const ScoreLevels> levels_;
  mutable std::once_flag made_;
  mutable std::shared_ptr<const ScoreTable> table_;
};

}  // namespace edge_mcl
