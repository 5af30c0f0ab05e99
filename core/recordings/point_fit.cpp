#include "edge_mcl/core/recordings/point_fit.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

/// Eigenvalues of the sum of squares about the mean, ascending.
Eigen::Vector3d spreadOf(const Eigen::Matrix3Xd& points) {
  const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(centred * centred.transpose())
      .eigenvalues()
      .cwiseMax(0);
}

/// Points on a line leave the rotation about it open.
bool isLine(const Eigen::Matrix3Xd& points) {
  constexpr double kThin = 1e-3;  // width of the points for their length
  const Eigen::Vector3d spread = spreadOf(points);
  return !(std::sqrt(spread[1]) > kThin * std::sqrt(spread[2]));
}

}  // namespace

PointFit fitPoints(const std::vector<PointPair>& pairs, std::optional<double> scale) {
  if (pairs.size() < 3) throw InputError("three pairs of points or more are needed");
  const auto count = static_cast<Eigen::Index>(pairs.size());
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    from.col(i) = scale.value_or(1) * pairs[static_cast<size_t>(i)].from;
    to.col(i) = pairs[static_cast<size_t>(i)].to;
  }
  if (!from.allFinite() || !to.allFinite()) throw InputError("a coordinate is not finite");
  if (isLine(from) || isLine(to))
    throw InputError("the points lie on a line, so the rotation about it is open");
  const Eigen::Matrix4d fitted = Eigen::umeyama(from, to, !scale);
  PointFit fit;
  const double factor = std::cbrt(fitted.topLeftCorner<3, 3>().determinant());
  fit.similarity.rotation = fitted.topLeftCorner<3, 3>() / factor;
  fit.similarity.shift = fitted.topRightCorner<3, 1>();
  fit.similarity.scale = factor * scale.value_or(1);
  double sum = 0;
  for (const PointPair& pair : pairs) {
    fit.residuals.push_back((fit.similarity * pair.from - pair.to).norm());
    sum += fit.residuals.back() * fit.residuals.back();
  }
  const auto n = static_cast<double>(pairs.size());
  fit.rms = std::sqrt(sum / n);
  // 3 n numbers, less the unknowns of the similarity.
  const double sigma = std::sqrt(sum / (3 * n - (scale ? 6 : 7)));
  const Eigen::Vector3d spread = spreadOf(to);
  fit.position_sigma = sigma / std::sqrt(n);
  fit.rotation_sigma = sigma / std::sqrt(spread[0] + spread[1]);
  if (!scale) fit.scale_sigma = fit.similarity.scale * sigma / std::sqrt(spread.sum());
  return fit;
}

}  // namespace edge_mcl
