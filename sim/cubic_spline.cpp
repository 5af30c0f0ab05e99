#include "edge_mcl/sim/cubic_spline.h"

#include <algorithm>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

CubicSpline::CubicSpline(std::vector<double> times, std::vector<double> values)
    : times_(std::move(times)), values_(std::move(values)), curvatures_(times_.size(), 0) {
  const size_t n = times_.size();
  if (n < 2 || values_.size() != n) throw Error("spline: at least two points are needed");
  for (size_t i = 1; i < n; ++i)
    if (!(times_[i] > times_[i - 1])) throw Error("spline: the times do not increase");
  // The second derivatives solve a tridiagonal system and are zero at both ends (W. Press et al.,
  // "Numerical Recipes", 3.3). It is solved by elimination and back substitution.
  std::vector<double> upper(n, 0), right(n, 0);
  for (size_t i = 1; i + 1 < n; ++i) {
    const double h0 = times_[i] - times_[i - 1], h1 = times_[i + 1] - times_[i];
    const double slope0 = (values_[i] - values_[i - 1]) / h0;
    const double slope1 = (values_[i + 1] - values_[i]) / h1;
    const double pivot = 2 * (h0 + h1) - h0 * upper[i - 1];
    upper[i] = h1 / pivot;
    right[i] = (6 * (slope1 - slope0) - h0 * right[i - 1]) / pivot;
  }
  for (size_t i = n - 1; i-- > 1;) curvatures_[i] = right[i] - upper[i] * curvatures_[i + 1];
}

double CubicSpline::at(double time, int order) const {
  if (time < begin() || time > end()) {
    if (order > 0) return 0;
    return time < begin() ? values_.front() : values_.back();
  }
  const auto after = std::upper_bound(times_.begin(), times_.end(), time);
  const size_t i = std::min<size_t>(after - times_.begin(), times_.size() - 1) - 1;
  const double h = times_[i + 1] - times_[i];
  const double b = (time - times_[i]) / h, a = 1 - b;
  const double m0 = curvatures_[i], m1 = curvatures_[i + 1];
  if (order == 2) return a * m0 + b * m1;
  if (order == 1)
    return (values_[i + 1] - values_[i]) / h +
           h / 6 * ((3 * b * b - 1) * m1 - (3 * a * a - 1) * m0);
  return a * values_[i] + b * values_[i + 1] +
         h * h / 6 * ((a * a * a - a) * m0 + (b * b * b - b) * m1);
}

}  // namespace edge_mcl
