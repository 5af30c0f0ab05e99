/// Natural cubic spline through points in time: position, velocity and acceleration are continuous.
#pragma once

#include <vector>

namespace edge_mcl {

class CubicSpline {
 public:
  CubicSpline() = default;
  /// @param times strictly increasing, at least two. @throws Error otherwise.
  CubicSpline(std::vector<double> times, std::vector<double> values);

  double begin() const { return times_.front(); }
  double end() const { return times_.back(); }
  /// @param order 0 to 2: value, first, second derivative. Constant beyond the ends.
  double at(double time, int order = 0) const;

 private:
  std::vector<double> times_, values_, curvatures_;
};

}  // namespace edge_mcl
