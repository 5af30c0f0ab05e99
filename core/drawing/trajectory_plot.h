/// Draws trajectories.
#pragma once

#include <opencv2/core.hpp>

#include "edge_mcl/core/recordings/text_table.h"

namespace edge_mcl {

/// An estimated trajectory and, if there is one, the reference: from above, from the side, and each
/// coordinate over time. Axes are metres and seconds, in the map frame.
/// @return CV_8UC3
cv::Mat drawTrajectories(const Trajectory& estimate, const Trajectory& truth);

}  // namespace edge_mcl
