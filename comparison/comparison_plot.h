/// The comparison as pictures.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/comparison/comparison_report.h"

namespace edge_mcl {

/// A panel per sequence: median position error over milliseconds per update, both logarithmic;
/// lines join the particle numbers of a method.
cv::Mat drawAccuracy(const std::vector<ComparedRow>& rows);

/// A panel per sequence: position error along the flight, of every method's first seed.
cv::Mat drawErrors(const std::vector<ComparedRun>& runs);

}  // namespace edge_mcl
