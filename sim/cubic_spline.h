/// Interpolates a value over time with a natural cubic spline.
#pragma once

#include <vector>

namespace edge_mcl {

/// Natural cubic spline through points in time. Value, first and second derivative are continuous.
/// Source: W. Press et al., "Numerical Recipes", 3.3.
class CubicSpline {
 public:
  CubicSpline() = default;
  /// @param times strictly increasing, at least two. @param values one for each time.
  /// @throws Error otherwise.
  CubicSpline(std::vector<double> times, std::vector<double> values);

  double begin() const { return times_.front(); }
  double end() const { return times_.back(); }
  /// Returns the spline at a time. Before the first and after the last point the value is constant
  /// and the derivatives are 0. @param order 0: value, 1: first derivative, 2: second derivative.
  double at(double time, int order = 0) const;

 private:
  std::vector<double> times_, values_, curvatures_;
};

}  // namespace edge_mcl
