#include "edge_mcl/localization/filter/look_alikes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

namespace {

using Eigen::Vector3d;

/// A shorter shift leaves the pose right, or the refinement takes it back. A longer one leaves the
/// part of the model that is in view.
constexpr double kShortest = 0.12, kLongest = 1.2;  // m
/// Shifts are counted in cells of this size, m. Repeats of a building are equal to a centimetre.
constexpr double kCell = 0.04;
/// Pairs of lines that must have the shift.
constexpr int kLeastPairs = 3;
/// Shifts that are tried, each in both directions.
constexpr size_t kMostShifts = 4;
/// Longest lines in view that are compared with one another.
constexpr size_t kMostLines = 120;
constexpr double kParallel = 0.9994;  // cosine of 2 degrees
/// A look-alike that ends this near to the pose is the pose itself.
constexpr double kSame = 0.08;  // m
/// A repeat of a building moves the pose and does not turn it. A refinement that ends elsewhere has
/// found something by chance. Those of docs/decisions/tracking-look-alikes.md end within 2 cm of
/// the shift and 1 degree.
constexpr double kFromShift = 0.12;      // m
constexpr double kTurned = 3 * kDegree;  // against the pose, whose rotation may be off

struct LineInView {
  Vector3d middle, tangent;
  double length = 0;
};

std::vector<LineInView> linesInView(const LocalizationMap& map, const CameraView& view,
                                    const Pose& T_map_camera) {
  const CameraModel& camera = view.image->frame.camera;
  const Pose camera_from_map = T_map_camera.inverse();
  const auto set = map.visibility().cached(map.visibility().cellOf(T_map_camera.translation()));
  std::map<uint32_t, double> seen;  // by line: number of samples in view
  for (const VisibleSet::Segment& s : set->segments) {
    Eigen::Vector2d pixel;
    const EdgeSegment& segment = set->edgeSegment(s);
    if (camera.project(camera_from_map * segment.centre.cast<double>(), &pixel) &&
        camera.contains(pixel))
      seen[segment.line] += segment.sample_count;
  }
  std::vector<LineInView> lines;
  for (const auto& [number, samples] : seen) {
    const EdgeLine& line = map.edges().lines[number];
    if (line.kind == EdgeKind::kContour) continue;
    lines.push_back({(line.start + line.end).cast<double>() / 2, line.tangent().cast<double>(),
                     samples * map.edges().sample_step});
  }
  const size_t most = std::min(kMostLines, lines.size());
  std::partial_sort(lines.begin(), lines.begin() + static_cast<long>(most), lines.end(),
                    [](const LineInView& a, const LineInView& b) { return a.length > b.length; });
  lines.resize(most);
  return lines;
}

struct Votes {
  double length = 0;
  int pairs = 0;
  Vector3d sum = Vector3d::Zero();
};

}  // namespace

std::vector<Vector3d> repeatsInView(const LocalizationMap& map, const CameraView& view,
                                    const Pose& T_map_camera) {
  const std::vector<LineInView> lines = linesInView(map, view, T_map_camera);
  std::map<std::array<int, 3>, Votes> votes;
  for (size_t i = 0; i < lines.size(); ++i)
    for (size_t j = 0; j < lines.size(); ++j) {
      if (i == j || std::abs(lines[i].tangent.dot(lines[j].tangent)) < kParallel) continue;
      const Vector3d between = lines[j].middle - lines[i].middle;
      const Vector3d shift = between - between.dot(lines[i].tangent) * lines[i].tangent;
      if (shift.norm() < kShortest || shift.norm() > kLongest) continue;
      std::array<int, 3> cell{};
      for (int k = 0; k < 3; ++k) cell.at(k) = static_cast<int>(std::lround(shift[k] / kCell));
      Votes& vote = votes[cell];
      vote.length += std::min(lines[i].length, lines[j].length);
      vote.sum += shift;
      ++vote.pairs;
    }
  std::vector<Votes> best;
  for (const auto& [cell, vote] : votes)
    if (vote.pairs >= kLeastPairs) best.push_back(vote);
  std::stable_sort(best.begin(), best.end(),
                   [](const Votes& a, const Votes& b) { return a.length > b.length; });
  std::vector<Vector3d> shifts;
  for (const Votes& vote : best) {
    const Vector3d shift = vote.sum / vote.pairs;
    const bool is_known = std::any_of(shifts.begin(), shifts.end(), [&](const Vector3d& known) {
      return (known - shift).norm() < 2 * kCell || (known + shift).norm() < 2 * kCell;
    });
    if (is_known) continue;
    shifts.push_back(shift);
    shifts.push_back(-shift);
    if (shifts.size() >= 2 * kMostShifts) break;
  }
  return shifts;
}

std::optional<LookAlike> bestLookAlike(const LocalizationMap& map,
                                       const std::vector<CameraView>& views, const Pose& pose) {
  const auto view =
      std::find_if(views.begin(), views.end(), [](const CameraView& v) { return v.image; });
  if (view == views.end()) return std::nullopt;
  // The pose itself is refined, too. Its estimate leans on the prediction, the others do not.
  std::vector<Pose> poses{pose, map.refineRoughly(views, pose, std::nullopt).pose};
  if ((poses[1].translation() - pose.translation()).norm() > kSame) poses[1] = pose;
  for (const Vector3d& shift : repeatsInView(map, *view, pose * view->T_base_camera)) {
    Pose start = pose;
    start.translation() += shift;
    const Pose end = map.refineRoughly(views, start, std::nullopt).pose;
    if ((end.translation() - pose.translation()).norm() > kSame &&
        (end.translation() - start.translation()).norm() < kFromShift &&
        rotationAngle(end, pose) < kTurned)
      poses.push_back(end);
  }
  if (poses.size() == 2) return std::nullopt;
  const std::vector<PoseScore> scores = map.evaluate(views, poses);
  const double own = std::max(scores[0].log_likelihood, scores[1].log_likelihood);
  size_t best = 2;
  for (size_t i = 3; i < scores.size(); ++i)
    if (scores[i].log_likelihood > scores[best].log_likelihood) best = i;
  return LookAlike{poses[best], scores[best].log_likelihood - own};
}

}  // namespace edge_mcl
