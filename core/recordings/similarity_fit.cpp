#include "edge_mcl/core/recordings/similarity_fit.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

/// The rotation nearest to the mean of rotations (chordal mean).
Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& sum) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

struct Middle {
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
};

Middle middleOf(const std::vector<PosePair>& pairs) {
  Middle middle;
  for (const PosePair& pair : pairs) {
    middle.from += pair.from.translation();
    middle.to += pair.to.translation();
  }
  middle.from /= static_cast<double>(pairs.size());
  middle.to /= static_cast<double>(pairs.size());
  return middle;
}

Similarity leastSquares(const std::vector<PosePair>& pairs, bool scale_is_known) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) sum += pair.to.linear() * pair.from.linear().transpose();
  Similarity result;
  result.rotation = nearestRotation(sum);
  const Middle middle = middleOf(pairs);
  double along = 0, square = 0;
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d turned = result.rotation * (pair.from.translation() - middle.from);
    along += (pair.to.translation() - middle.to).dot(turned);
    square += turned.squaredNorm();
  }
  if (!scale_is_known && square > 0) result.scale = along / square;
  result.shift = middle.to - result.scale * (result.rotation * middle.from);
  return result;
}

double offset(const Similarity& s, const PosePair& pair) {
  return (s * pair.from.translation() - pair.to.translation()).norm();
}

double turn(const Similarity& s, const PosePair& pair) {
  return logSo3(pair.to.linear().transpose() * s.rotation * pair.from.linear()).norm();
}

double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The pairs that agree with a similarity.
std::vector<PosePair> agreeing(const std::vector<PosePair>& pairs, const Similarity& s) {
  constexpr double kMedians = 3, kExactPosition = 0.01, kExactAngle = 0.005;  // m, rad
  std::vector<double> offsets, turns;
  for (const PosePair& pair : pairs) {
    offsets.push_back(offset(s, pair));
    turns.push_back(turn(s, pair));
  }
  const double most_offset = std::max(kExactPosition, kMedians * medianOf(offsets));
  const double most_turn = std::max(kExactAngle, kMedians * medianOf(turns));
  std::vector<PosePair> kept;
  for (size_t i = 0; i < pairs.size(); ++i)
    if (offsets[i] <= most_offset && turns[i] <= most_turn) kept.push_back(pairs[i]);
  return kept;
}

/// Root of the mean square distance from the middle, and the rotation by the positions alone.
struct Spread {
  double radius = 0;
  double second = 0;  // singular value of the second axis over that of the first
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

Spread spreadOf(const std::vector<PosePair>& pairs) {
  const Middle middle = middleOf(pairs);
  Eigen::Matrix3d between = Eigen::Matrix3d::Zero(), own = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d a = pair.from.translation() - middle.from;
    between += (pair.to.translation() - middle.to) * a.transpose();
    own += a * a.transpose();
  }
  Spread spread;
  spread.radius = std::sqrt(own.trace() / static_cast<double>(pairs.size()));
  const Eigen::JacobiSVD<Eigen::Matrix3d> axes(own);
  spread.second = std::sqrt(axes.singularValues()[1] / std::max(1e-12, axes.singularValues()[0]));
  spread.rotation = nearestRotation(between);
  return spread;
}

}  // namespace

SimilarityFit fitSimilarity(const std::vector<PosePair>& pairs, bool scale_is_known) {
  constexpr size_t kFewest = 10;
  constexpr int kRounds = 5;
  if (pairs.size() < kFewest)
    throw InputError("only " + std::to_string(pairs.size()) +
                     " poses are known in both systems; at least ten are needed");
  std::vector<PosePair> used = pairs;
  SimilarityFit fit;
  for (int round = 0; round < kRounds; ++round) {
    fit.similarity = leastSquares(used, scale_is_known);
    std::vector<PosePair> kept = agreeing(pairs, fit.similarity);
    if (kept.size() < kFewest) break;
    used = std::move(kept);
  }
  const Spread spread = spreadOf(used);
  constexpr double kFarEnough = 0.1;  // m, root of the mean square; a flight of 0.3 m
  if (!scale_is_known && spread.radius < kFarEnough)
    throw InputError("the poses lie within " + std::to_string(spread.radius) +
                     " m, too close for a scale; fly farther, or keep the scale");
  fit.used = used.size();
  for (const PosePair& pair : used) {
    fit.position_rms += std::pow(offset(fit.similarity, pair), 2);
    fit.rotation_rms += std::pow(turn(fit.similarity, pair), 2);
  }
  fit.position_rms = std::sqrt(fit.position_rms / static_cast<double>(used.size()));
  fit.rotation_rms = std::sqrt(fit.rotation_rms / static_cast<double>(used.size()));
  // Errors of neighbouring images are alike. So ten images count as one.
  constexpr double kAlike = 10;
  const double root = std::sqrt(std::max(1.0, static_cast<double>(used.size()) / kAlike));
  fit.position_sigma = fit.position_rms / root;
  fit.rotation_sigma = fit.rotation_rms / root;
  fit.scale_sigma = scale_is_known ? 0 : fit.position_sigma / spread.radius;
  constexpr double kPlane = 0.2;  // smaller: the positions lie on a line
  if (spread.second > kPlane)
    fit.disagreement = logSo3(spread.rotation.transpose() * fit.similarity.rotation).norm();
  return fit;
}

}  // namespace edge_mcl
