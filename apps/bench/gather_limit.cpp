// This file is compiled once per instruction set, like the kernel.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "apps/bench/gather_limit.cpp"
#include <hwy/foreach_target.h>
// foreach_target must come first.
#include <hwy/highway.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "apps/bench/gather_limit.h"
#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"

HWY_BEFORE_NAMESPACE();
namespace edge_mcl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Does both gathers of the kernel for every sample and every particle.
/// @param bases offset of every sample in the table, bytes.
/// @param shifts offset that a particle adds, bytes; their number is a multiple of 16. Every base
/// plus every shift must lie inside the table.
/// @return a checksum, so that the compiler keeps the gathers
uint32_t gatherAllImpl(const uint16_t* pairs, int stride, const std::vector<int32_t>& bases,
                       const std::vector<int32_t>& shifts) {
  const hn::CappedTag<int32_t, 16> d;
  const auto* top = reinterpret_cast<const int32_t*>(pairs);
  const auto* bottom = reinterpret_cast<const int32_t*>(pairs + stride);
  auto sum = hn::Zero(d);
  for (const int32_t base : bases) {
    const auto at = hn::Set(d, base);
    for (size_t p = 0; p < shifts.size(); p += hn::Lanes(d)) {
      const auto offset = hn::Add(at, hn::LoadU(d, shifts.data() + p));
      sum = hn::Add(sum,
                    hn::Xor(hn::GatherOffset(d, top, offset), hn::GatherOffset(d, bottom, offset)));
    }
  }
  return static_cast<uint32_t>(hn::GetLane(hn::SumOfLanes(d, sum)));
}

}  // namespace HWY_NAMESPACE
}  // namespace edge_mcl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace edge_mcl {
HWY_EXPORT(gatherAllImpl);

namespace {

/// How far a point 3 m in front of the camera moves in the image, px, when the camera moves from
/// one pose to another (T_map_camera).
Eigen::Vector2d shiftOf(const CameraModel& camera, const Pose& from, const Pose& to) {
  Eigen::Vector2d a, b;
  const Eigen::Vector3d p(0, 0, 3);
  if (!camera.project(p, &a) || !camera.project(to.inverse() * (from * p), &b))
    return Eigen::Vector2d::Zero();
  return b - a;
}

}  // namespace

double gatherLimitNanoseconds(const LikelihoodFrame& frame, const VisibleSet& set,
                              const std::vector<Pose>& camera_poses, int repeats) {
  const std::shared_ptr<const ScoreTable> kept = frame.tableHere();
  const ScoreTable& table = *kept;
  const Pose& centre = camera_poses.front();
  // Shifts are shorter than this margin, so that no address leaves the table. The particles of a
  // benchmark move the image by some 20 pixels.
  constexpr int kMargin = 64;
  constexpr size_t kMostLanes = 16;  // floats in the widest vector, AVX-512
  constexpr int kPairBytes = 2;      // an element of the table is a pair of bytes
  std::vector<int32_t> shifts;
  for (const Pose& pose : camera_poses) {
    const Eigen::Vector2d shift = shiftOf(frame.camera, centre, pose);
    const auto clamped = [](double v) {
      return std::lround(std::clamp(v, 1.0 - kMargin, kMargin - 1.0));
    };
    shifts.push_back(static_cast<int32_t>(
        kPairBytes * (clamped(shift.y()) * table.stride() + clamped(shift.x()))));
  }
  while (shifts.size() % kMostLanes != 0) shifts.push_back(shifts.back());
  std::vector<int32_t> bases;
  const Pose camera_from_map = centre.inverse();
  for (const VisibleSet::Segment& segment : set.segments) {
    const EdgeSegment& edge = set.edgeSegment(segment);
    for (uint32_t i = 0; i < edge.sample_count; ++i) {
      if (!(segment.samples >> i & 1u)) continue;
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> jacobian;
      if (!frame.camera.project(camera_from_map * set.model->samplePosition(edge, i), &pixel,
                                &jacobian) ||
          !frame.camera.contains(pixel))
        continue;
      const Eigen::Vector2d direction =
          jacobian * (camera_from_map.linear() * set.line(segment).tangent().cast<double>());
      const int bin =
          static_cast<int>(diamondAngle(direction.x(), direction.y()) * table.bins() / 2);
      const int x = std::clamp(static_cast<int>(pixel.x()), kMargin, table.width() - kMargin - 2);
      const int y = std::clamp(static_cast<int>(pixel.y()), kMargin, table.height() - kMargin - 2);
      bases.push_back(kPairBytes * ((bin % table.bins() * table.rows() + y) * table.stride() + x));
    }
  }
  if (bases.empty() || table.width() < 2 * kMargin + 3 || table.height() < 2 * kMargin + 3)
    return 0;
  std::vector<double> nanoseconds;
  volatile uint32_t sink = 0;
  for (int k = 0; k < repeats; ++k) {
    const auto start = std::chrono::steady_clock::now();
    sink = sink + HWY_DYNAMIC_DISPATCH(gatherAllImpl)(table.pairs(), table.stride(), bases, shifts);
    nanoseconds.push_back(
        std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count() /
        (static_cast<double>(bases.size()) * static_cast<double>(shifts.size())));
  }
  return summarize(std::move(nanoseconds)).median;
}

}  // namespace edge_mcl
#endif
