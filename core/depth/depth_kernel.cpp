// Scores depth points by their distance from the model, a vector of points at a time. This file is
// compiled once per instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "edge_mcl/core/depth/depth_kernel.cpp"
#include <hwy/foreach_target.h>
// foreach_target must come first.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "edge_mcl/core/depth/depth_kernel.h"
#include "edge_mcl/core/depth/depth_points.h"

HWY_BEFORE_NAMESPACE();
namespace edge_mcl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DepthD = hn::CappedTag<float, DepthPoints::kPadding>;
using DepthDI = hn::RebindToSigned<DepthD>;
using DepthV = hn::Vec<DepthD>;

/// Sum of the lanes in double precision, in the order of the lanes.
HWY_INLINE double sumOf(DepthD d, DepthV v) {
  alignas(64) float lanes[DepthPoints::kPadding];
  hn::Store(v, d, lanes);
  double sum = 0;
  for (size_t i = 0; i < hn::Lanes(d); ++i) sum += static_cast<double>(lanes[i]);
  return sum;
}

DepthKernelResult runDepthKernelImpl(const DistanceField::Grid& grid,
                                     const DepthKernelPoints& points, const DepthKernelPose& pose,
                                     float clutter) {
  const DepthD d;
  const DepthDI di;
  const size_t lanes = hn::Lanes(d);
  const DepthV zero = hn::Zero(d), half = hn::Set(d, 0.5f);
  const DepthV v_clutter = hn::Set(d, clutter);
  const DepthV step = hn::Set(d, static_cast<float>(grid.distance_step));
  const DepthV slope = hn::Set(d, static_cast<float>(grid.voxel_size / 127));
  const auto far = hn::Set(di, static_cast<int32_t>(DistanceField::kFar));
  const auto seven = hn::Set(di, DistanceField::kBrick - 1);
  const DepthV edge[3] = {hn::Set(d, static_cast<float>(grid.bricks[0] * DistanceField::kBrick)),
                          hn::Set(d, static_cast<float>(grid.bricks[1] * DistanceField::kBrick)),
                          hn::Set(d, static_cast<float>(grid.bricks[2] * DistanceField::kBrick))};
  const auto bricks_x = hn::Set(di, grid.bricks[0]), bricks_y = hn::Set(di, grid.bricks[1]);
  const float* r = pose.rotation;
  const auto* voxels = reinterpret_cast<const int32_t*>(grid.voxel);

  // One logarithm serves a product of this many factors. Each factor is some tenths to some tens.
  constexpr size_t kFactors = 8;
  DepthV product = hn::Set(d, 1.0f), score = zero, agreement = zero;
  size_t factors = 0;
  for (size_t i = 0; i < points.count; i += lanes) {
    const DepthV px = hn::LoadU(d, points.x + i), py = hn::LoadU(d, points.y + i),
                 pz = hn::LoadU(d, points.z + i);
    DepthV q[3], offset[3];
    hn::Vec<DepthDI> cell[3];
    auto inside = hn::Eq(zero, zero);
    for (int k = 0; k < 3; ++k) {
      q[k] = hn::MulAdd(hn::Set(d, r[3 * k]), px, hn::Set(d, pose.translation[k]));
      q[k] = hn::MulAdd(hn::Set(d, r[3 * k + 1]), py, q[k]);
      q[k] = hn::MulAdd(hn::Set(d, r[3 * k + 2]), pz, q[k]);
      inside = hn::And(inside, hn::And(hn::Ge(q[k], zero), hn::Lt(q[k], edge[k])));
    }
    for (int k = 0; k < 3; ++k) {
      const DepthV in_grid = hn::IfThenElse(inside, q[k], zero);
      cell[k] = hn::ConvertTo(di, in_grid);
      offset[k] = hn::Sub(hn::Sub(in_grid, hn::ConvertTo(d, cell[k])), half);
    }
    const auto brick_at = hn::Add(
        hn::Mul(hn::Add(hn::Mul(hn::ShiftRight<3>(cell[2]), bricks_y), hn::ShiftRight<3>(cell[1])),
                bricks_x),
        hn::ShiftRight<3>(cell[0]));
    const auto brick =
        hn::IfThenElseZero(hn::RebindMask(di, inside), hn::GatherIndex(di, grid.brick, brick_at));
    const auto in_brick = hn::Or(hn::Or(hn::ShiftLeft<6>(hn::And(cell[2], seven)),
                                        hn::ShiftLeft<3>(hn::And(cell[1], seven))),
                                 hn::And(cell[0], seven));
    const auto word = hn::GatherIndex(di, voxels, hn::Add(hn::ShiftLeft<9>(brick), in_brick));
    const auto steps = hn::And(word, far);
    const DepthV gx = hn::ConvertTo(d, hn::ShiftRight<24>(hn::ShiftLeft<16>(word)));
    const DepthV gy = hn::ConvertTo(d, hn::ShiftRight<24>(hn::ShiftLeft<8>(word)));
    const DepthV gz = hn::ConvertTo(d, hn::ShiftRight<24>(word));
    DepthV along = hn::Mul(gx, offset[0]);
    along = hn::MulAdd(gy, offset[1], along);
    along = hn::MulAdd(gz, offset[2], along);
    const DepthV distance = hn::MulAdd(along, slope, hn::Mul(hn::ConvertTo(d, steps), step));
    const DepthV exponent = hn::Neg(
        hn::Mul(hn::Mul(distance, distance), hn::LoadU(d, points.half_inverse_variance + i)));
    DepthV on_model = hn::Mul(hn::LoadU(d, points.peak + i), hn::Exp(d, exponent));
    on_model = hn::IfThenZeroElse(hn::RebindMask(d, hn::Eq(steps, far)), on_model);
    const DepthV both = hn::Add(v_clutter, on_model);
    agreement = hn::Add(agreement, hn::Div(on_model, both));
    product = hn::Mul(product, both);
    if (++factors == kFactors) {
      score = hn::Add(score, hn::Log(d, product));
      product = hn::Set(d, 1.0f);
      factors = 0;
    }
  }
  score = hn::Add(score, hn::Log(d, product));
  return {sumOf(d, score), sumOf(d, agreement)};
}

}  // namespace HWY_NAMESPACE
}  // namespace edge_mcl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace edge_mcl {
HWY_EXPORT(runDepthKernelImpl);

DepthKernelResult runDepthKernel(const DistanceField::Grid& grid, const DepthKernelPoints& points,
                                 const DepthKernelPose& pose, float clutter) {
  return HWY_DYNAMIC_DISPATCH(runDepthKernelImpl)(grid, points, pose, clutter);
}

}  // namespace edge_mcl
#endif
