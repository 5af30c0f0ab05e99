// The measurement model for a vector of particles. Compiled once per instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "edge_mcl/core/cpu_kernel.cpp"
#include <hwy/foreach_target.h>
// foreach_target must come first.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "edge_mcl/core/camera_model.h"
#include "edge_mcl/core/cpu_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace edge_mcl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, KernelBlock::kLanePadding>;
using DI = hn::RebindToSigned<D>;
using DU = hn::RebindToUnsigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using VU = hn::Vec<DU>;

/// 1/v to within two units in the last place.
HWY_INLINE V reciprocal(D d, V v) {
  const V guess = hn::ApproximateReciprocal(v);
  const V once = hn::Mul(guess, hn::NegMulAdd(v, guess, hn::Set(d, 2.0f)));
  return hn::Mul(once, hn::NegMulAdd(v, once, hn::Set(d, 2.0f)));
}

/// Sum with a carried rounding error (Knuth's two-sum).
struct CompensatedSum {
  V sum, error;
  explicit CompensatedSum(D d) : sum(hn::Zero(d)), error(hn::Zero(d)) {}
  HWY_INLINE void add(V x) {
    const V total = hn::Add(sum, x);
    const V part = hn::Sub(total, sum);
    const V lost = hn::Add(hn::Sub(sum, hn::Sub(total, part)), hn::Sub(x, part));
    error = hn::Add(error, lost);
    sum = total;
  }
};

/// Normalised image coordinates after distortion, and the distortion's Jacobian.
struct Distorted {
  V x, y, j00, j01, j11;
};

template <int kModel>
HWY_INLINE Distorted distort(D d, V x, V y, V r2, const KernelCamera& camera) {
  const auto k = [&](int i) { return hn::Set(d, camera.k[i]); };
  const V one = hn::Set(d, 1.0f), two = hn::Set(d, 2.0f);
  Distorted out;
  if constexpr (kModel == static_cast<int>(DistortionModel::kEquidistant)) {
    const V r2_safe = hn::Max(r2, hn::Set(d, 1e-14f));
    const V r = hn::Sqrt(r2_safe);
    const V theta = hn::Atan(d, r);
    const V t2 = hn::Mul(theta, theta);
    const V poly =
        hn::MulAdd(t2, hn::MulAdd(t2, hn::MulAdd(t2, hn::MulAdd(t2, k(3), k(2)), k(1)), k(0)), one);
    const V slope = hn::MulAdd(t2,
                               hn::MulAdd(t2,
                                          hn::MulAdd(t2,
                                                     hn::MulAdd(t2, hn::Mul(hn::Set(d, 9.0f), k(3)),
                                                                hn::Mul(hn::Set(d, 7.0f), k(2))),
                                                     hn::Mul(hn::Set(d, 5.0f), k(1))),
                                          hn::Mul(hn::Set(d, 3.0f), k(0))),
                               one);
    const V scale = hn::Div(hn::Mul(theta, poly), r);
    const V radial = hn::Div(slope, hn::Add(one, r2));
    const V s = hn::Div(hn::Sub(radial, scale), r2_safe);
    out.x = hn::Mul(x, scale);
    out.y = hn::Mul(y, scale);
    out.j00 = hn::MulAdd(hn::Mul(s, x), x, scale);
    out.j01 = hn::Mul(hn::Mul(s, x), y);
    out.j11 = hn::MulAdd(hn::Mul(s, y), y, scale);
    return out;
  }
  V num = hn::MulAdd(r2, hn::MulAdd(r2, hn::MulAdd(r2, k(4), k(1)), k(0)), one);
  V num_d =
      hn::MulAdd(r2, hn::MulAdd(r2, hn::Mul(hn::Set(d, 3.0f), k(4)), hn::Mul(two, k(1))), k(0));
  if constexpr (kModel == static_cast<int>(DistortionModel::kRationalPolynomial)) {
    const V den = hn::MulAdd(r2, hn::MulAdd(r2, hn::MulAdd(r2, k(7), k(6)), k(5)), one);
    const V den_d =
        hn::MulAdd(r2, hn::MulAdd(r2, hn::Mul(hn::Set(d, 3.0f), k(7)), hn::Mul(two, k(6))), k(5));
    const V inverse = hn::Div(one, den);
    num_d = hn::Mul(hn::Sub(hn::Mul(num_d, den), hn::Mul(num, den_d)), hn::Mul(inverse, inverse));
    num = hn::Mul(num, inverse);
  }
  const V p1 = k(2), p2 = k(3), xy = hn::Mul(x, y), xx = hn::Mul(x, x), yy = hn::Mul(y, y);
  const V two_p1 = hn::Mul(two, p1), two_p2 = hn::Mul(two, p2), six = hn::Set(d, 6.0f);
  out.x = hn::MulAdd(x, num, hn::MulAdd(two_p1, xy, hn::Mul(p2, hn::MulAdd(two, xx, r2))));
  out.y = hn::MulAdd(y, num, hn::MulAdd(p1, hn::MulAdd(two, yy, r2), hn::Mul(two_p2, xy)));
  const V two_d = hn::Mul(two, num_d);
  out.j00 =
      hn::MulAdd(two_d, xx, hn::Add(num, hn::MulAdd(two_p1, y, hn::Mul(six, hn::Mul(p2, x)))));
  out.j01 = hn::MulAdd(two_d, xy, hn::MulAdd(two_p1, x, hn::Mul(two_p2, y)));
  out.j11 =
      hn::MulAdd(two_d, yy, hn::Add(num, hn::MulAdd(two_p2, x, hn::Mul(six, hn::Mul(p1, y)))));
  return out;
}

/// Bilinear value of a word of four bytes.
HWY_INLINE V bilinear(D d, VU word, V fx, V fy) {
  const DU du;
  const DI di;
  const VU low = hn::Set(du, 0xffu);
  const auto byte = [&](VU v) { return hn::ConvertTo(d, hn::BitCast(di, v)); };
  const V a = byte(hn::And(word, low));
  const V b = byte(hn::And(hn::ShiftRight<8>(word), low));
  const V c = byte(hn::And(hn::ShiftRight<16>(word), low));
  const V e = byte(hn::ShiftRight<24>(word));
  const V top = hn::MulAdd(fx, hn::Sub(b, a), a);
  const V bottom = hn::MulAdd(fx, hn::Sub(e, c), c);
  return hn::MulAdd(fy, hn::Sub(bottom, top), top);
}

template <int kModel>
void scoreLanes(const KernelBlock& block, size_t first_lane, const KernelCamera& camera,
                const KernelTable& table, const KernelLineRule& rule, KernelResult* results) {
  const D d;
  const DI di;
  const DU du;
  V pose[12];
  for (int i = 0; i < 12; ++i) pose[i] = hn::LoadU(d, block.pose[i].data() + first_lane);
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const V fx = hn::Set(d, camera.fx), fy = hn::Set(d, camera.fy);
  const V cx = hn::Set(d, camera.cx), cy = hn::Set(d, camera.cy);
  const V last_x = hn::Set(d, camera.last_x), last_y = hn::Set(d, camera.last_y);
  const V min_depth = hn::Set(d, camera.min_depth);
  const V inverse_fade = hn::Set(d, rule.inverse_fade);
  const V spacing_scale = hn::Set(d, rule.spacing_scale);
  const V half_bins = hn::Set(d, 0.5f * static_cast<float>(table.bins));
  const V scale = hn::Set(d, table.scale), offset = hn::Set(d, table.offset);
  const VI max_x = hn::Set(di, table.width - 2), max_y = hn::Set(di, table.height - 2);
  const VI width = hn::Set(di, table.width), height = hn::Set(di, table.height);
  const VI bins = hn::Set(di, table.bins), last_bin = hn::Set(di, table.bins - 1),
           izero = hn::Zero(di), ione = hn::Set(di, 1);
  const auto* words = reinterpret_cast<const int32_t*>(table.words);

  V group_score = zero, group_weight = zero;
  CompensatedSum line_sum(d);
  V line_count = zero, total_weight = zero;

  for (const KernelBlock::Segment& segment : block.segments) {
    const V sx = hn::Set(d, segment.tx), sy = hn::Set(d, segment.ty), sz = hn::Set(d, segment.tz);
    const V tx = hn::MulAdd(pose[0], sx, hn::MulAdd(pose[1], sy, hn::Mul(pose[2], sz)));
    const V ty = hn::MulAdd(pose[3], sx, hn::MulAdd(pose[4], sy, hn::Mul(pose[5], sz)));
    const V tz = hn::MulAdd(pose[6], sx, hn::MulAdd(pose[7], sy, hn::Mul(pose[8], sz)));
    const V segment_weight = hn::Set(d, segment.weight);
    for (uint32_t i = segment.first; i < segment.first + segment.count; ++i) {
      const V px = hn::Set(d, block.x[i]), py = hn::Set(d, block.y[i]), pz = hn::Set(d, block.z[i]);
      const V z =
          hn::MulAdd(pose[6], px, hn::MulAdd(pose[7], py, hn::MulAdd(pose[8], pz, pose[11])));
      const auto in_front = hn::Gt(z, min_depth);
      if (hn::AllFalse(d, in_front)) continue;
      const V cam_x =
          hn::MulAdd(pose[0], px, hn::MulAdd(pose[1], py, hn::MulAdd(pose[2], pz, pose[9])));
      const V cam_y =
          hn::MulAdd(pose[3], px, hn::MulAdd(pose[4], py, hn::MulAdd(pose[5], pz, pose[10])));
      const V iz = reciprocal(d, hn::Max(z, min_depth));
      const V xn = hn::Mul(cam_x, iz), yn = hn::Mul(cam_y, iz);
      // Direction of the projected edge, up to a positive factor.
      V a = hn::NegMulAdd(xn, tz, tx), b = hn::NegMulAdd(yn, tz, ty);
      V u, v, weight;
      if constexpr (kModel == static_cast<int>(DistortionModel::kNone)) {
        u = hn::MulAdd(fx, xn, cx);
        v = hn::MulAdd(fy, yn, cy);
        weight = hn::IfThenElseZero(in_front, segment_weight);
      } else {
        const V r2 = hn::MulAdd(xn, xn, hn::Mul(yn, yn));
        const auto inside = hn::And(in_front, hn::Le(r2, hn::Set(d, camera.max_radius2)));
        const Distorted q = distort<kModel>(d, xn, yn, r2, camera);
        u = hn::MulAdd(fx, q.x, cx);
        v = hn::MulAdd(fy, q.y, cy);
        const V a_distorted = hn::MulAdd(q.j00, a, hn::Mul(q.j01, b));
        b = hn::MulAdd(q.j01, a, hn::Mul(q.j11, b));
        a = a_distorted;
        weight = hn::IfThenElseZero(inside, segment_weight);
      }
      const V border = hn::Min(hn::Min(u, hn::Sub(last_x, u)), hn::Min(v, hn::Sub(last_y, v)));
      const V fade = hn::Min(one, hn::Mul(border, inverse_fade));
      weight = hn::IfThenElseZero(hn::Ge(border, zero), hn::Mul(weight, fade));
      if (hn::AllFalse(d, hn::Gt(weight, zero))) continue;

      // An edge seen end-on has no direction in the image: it fades out. In the robust model the
      // measure is the distance of neighbouring samples in the image.
      const V spacing = hn::Mul(hn::Add(hn::Abs(a), hn::Abs(b)), spacing_scale);
      weight = hn::Mul(weight, hn::Min(one, rule.paper ? spacing : hn::Mul(spacing, iz)));
      V du_image = hn::Mul(fx, a), dv_image = hn::Mul(fy, b);
      const auto downwards = hn::Lt(dv_image, zero);
      du_image = hn::IfThenElse(downwards, hn::Neg(du_image), du_image);
      dv_image = hn::Abs(dv_image);
      const V sum = hn::Max(hn::Add(hn::Abs(du_image), dv_image), hn::Set(d, 1e-20f));
      const V ratio = hn::Mul(dv_image, reciprocal(d, sum));
      const V diamond =
          hn::IfThenElse(hn::Ge(du_image, zero), ratio, hn::Sub(hn::Set(d, 2.0f), ratio));
      const V bin = hn::Mul(diamond, half_bins);
      const VI bin_floor = hn::ConvertTo(di, bin);
      const V bin_fraction = hn::Sub(bin, hn::ConvertTo(d, bin_floor));
      const VI bin_a =
          hn::IfThenElse(hn::Gt(bin_floor, last_bin), hn::Sub(bin_floor, bins), bin_floor);
      const VI bin_next = hn::Add(bin_a, ione);
      const VI bin_b = hn::IfThenElse(hn::Gt(bin_next, last_bin), izero, bin_next);

      const V u_safe = hn::Max(zero, hn::Min(u, last_x)),
              v_safe = hn::Max(zero, hn::Min(v, last_y));
      const VI ix = hn::Min(hn::ConvertTo(di, u_safe), max_x);
      const VI iy = hn::Min(hn::ConvertTo(di, v_safe), max_y);
      const V frac_x = hn::Sub(u_safe, hn::ConvertTo(d, ix));
      const V frac_y = hn::Sub(v_safe, hn::ConvertTo(d, iy));
      const VI at_a = hn::Add(hn::Mul(hn::Add(hn::Mul(bin_a, height), iy), width), ix);
      const VI at_b = hn::Add(hn::Mul(hn::Add(hn::Mul(bin_b, height), iy), width), ix);
      const VU word_a = hn::BitCast(du, hn::GatherIndex(di, words, at_a));
      const VU word_b = hn::BitCast(du, hn::GatherIndex(di, words, at_b));
      // A word of zero marks ignored pixels, the same in every bin.
      weight =
          hn::IfThenZeroElse(hn::RebindMask(d, hn::Eq(hn::BitCast(di, word_a), izero)), weight);
      const V value_a = bilinear(d, word_a, frac_x, frac_y);
      const V value_b = bilinear(d, word_b, frac_x, frac_y);
      const V value = hn::MulAdd(bin_fraction, hn::Sub(value_b, value_a), value_a);
      group_score = hn::MulAdd(weight, hn::MulAdd(scale, value, offset), group_score);
      group_weight = hn::Add(group_weight, weight);
    }
    if (!segment.ends_group) continue;
    if (rule.paper) {
      // Eq. (2); a line that just fades in counts partly.
      line_sum.add(hn::Mul(group_score, reciprocal(d, hn::Max(one, group_weight))));
      line_count = hn::Add(line_count, hn::Min(one, group_weight));
    } else {
      const V saturation = hn::Mul(group_weight, hn::Set(d, rule.inverse_saturation));
      const V share = reciprocal(d, hn::Add(saturation, one));
      line_sum.add(hn::Mul(group_score, share));
      line_count = hn::MulAdd(saturation, share, line_count);
    }
    total_weight = hn::Add(total_weight, group_weight);
    group_score = group_weight = zero;
  }

  HWY_ALIGN float sum[KernelBlock::kLanePadding], error[KernelBlock::kLanePadding],
      count[KernelBlock::kLanePadding], total[KernelBlock::kLanePadding];
  hn::Store(line_sum.sum, d, sum);
  hn::Store(line_sum.error, d, error);
  hn::Store(line_count, d, count);
  hn::Store(total_weight, d, total);
  for (size_t lane = 0; lane < hn::Lanes(d) && first_lane + lane < block.particles; ++lane)
    results[first_lane + lane] = {static_cast<double>(sum[lane]) + error[lane], total[lane],
                                  count[lane]};
}

template <int kModel>
void scoreBlock(const KernelBlock& block, const KernelCamera& camera, const KernelTable& table,
                const KernelLineRule& rule, KernelResult* results) {
  for (size_t lane = 0; lane < block.particles; lane += hn::Lanes(D()))
    scoreLanes<kModel>(block, lane, camera, table, rule, results);
}

void runKernelImpl(const KernelBlock& block, const KernelCamera& camera, const KernelTable& table,
                   const KernelLineRule& rule, KernelResult* results) {
  switch (static_cast<DistortionModel>(camera.distortion)) {
    case DistortionModel::kNone:
      return scoreBlock<0>(block, camera, table, rule, results);
    case DistortionModel::kPlumbBob:
      return scoreBlock<1>(block, camera, table, rule, results);
    case DistortionModel::kRationalPolynomial:
      return scoreBlock<2>(block, camera, table, rule, results);
    case DistortionModel::kEquidistant:
      return scoreBlock<3>(block, camera, table, rule, results);
  }
}

const char* targetNameImpl() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace edge_mcl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace edge_mcl {
HWY_EXPORT(runKernelImpl);
HWY_EXPORT(targetNameImpl);

void runKernel(const KernelBlock& block, const KernelCamera& camera, const KernelTable& table,
               const KernelLineRule& rule, KernelResult* results) {
  HWY_DYNAMIC_DISPATCH(runKernelImpl)(block, camera, table, rule, results);
}

const char* kernelTargetName() { return HWY_DYNAMIC_DISPATCH(targetNameImpl)(); }

}  // namespace edge_mcl
#endif
