// The measurement model for a vector of particles. Compiled once per instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "edge_mcl/core/likelihood/cpu_kernel.cpp"
#include <hwy/foreach_target.h>
// foreach_target must come first.
#include <hwy/highway.h>

#include <vector>

#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/likelihood/cpu_kernel.h"
#include "edge_mcl/core/likelihood/kernel_camera-inl.h"

HWY_BEFORE_NAMESPACE();
namespace edge_mcl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

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

/// An integer n with n <= v + 1/2 <= n + 1 for 0 <= v + 1/2 < 2^22, found by adding a number so
/// large that the sum has no fraction; where v + 1/2 is an integer it may be that or one less.
/// Cheaper than a conversion, which has to care for numbers out of range.
struct RoundedDown {
  static constexpr float kLarge = 12582912.0f;    // 1.5 * 2^23
  static constexpr uint32_t kBias = 0x4b400000u;  // its bits
  V value;
  HWY_INLINE RoundedDown(D d, V v)
      : value(hn::Sub(hn::Add(v, hn::Set(d, kLarge)), hn::Set(d, kLarge))) {}
  /// The integer plus kBias, modulo 2^32.
  HWY_INLINE VI bits(D d) const { return bits(d, value); }
  static HWY_INLINE VI bits(D d, V integer) {
    return hn::BitCast(DI(), hn::Add(integer, hn::Set(d, kLarge)));
  }
};

/// Bin of an edge's direction in the score table.
struct DirectionBin {
  V lower, fraction;  // lower + fraction in [0, bins]

  /// @param du, dv direction in the image, not normalised. @param abs_dv |dv|.
  /// @param length |du| + |dv|. @param half_bins half the number of bins.
  HWY_INLINE DirectionBin(D d, V du, V dv, V abs_dv, V length, float half_bins) {
    const V half = hn::Set(d, half_bins);
    // The next bin is stored beside each; a diamond angle of 2 is the end of the last.
    const V last = hn::Set(d, 2 * half_bins * (1 - 1e-7f) - 0.5f);
    // Diamond angle of the undirected edge: dv / (|du| + |dv|) in the first quadrant, 2 minus it
    // where the signs differ.
    const V ratio =
        hn::Mul(hn::Mul(abs_dv, half), reciprocal(d, hn::Max(length, hn::Set(d, 1e-20f))));
    const auto second = hn::Lt(hn::Mul(du, dv), hn::Zero(d));
    const V bin = hn::IfThenElse(second, hn::Sub(hn::Add(half, half), ratio), ratio);
    lower = RoundedDown(d, hn::Min(hn::Sub(bin, hn::Set(d, 0.5f)), last)).value;
    fraction = hn::Sub(bin, lower);
  }
};

/// Sums of one particle while its segments are worked through.
struct LaneSums {
  V group_score, group_weight;
  CompensatedSum line_sum;
  V line_count, total_weight;
  explicit LaneSums(D d)
      : group_score(hn::Zero(d)),
        group_weight(hn::Zero(d)),
        line_sum(d),
        line_count(hn::Zero(d)),
        total_weight(hn::Zero(d)) {}
};

/// One vector of particles.
template <int kModel>
class LaneScorer {
 public:
  LaneScorer(const KernelBlock& block, const KernelCamera& camera, const KernelTable& table,
             const KernelLineRule& rule)
      : block_(block), camera_(camera), table_(table), rule_(rule) {}

  /// Adds segment number s to the sums of the particles from `first_lane` on.
  HWY_INLINE void add(size_t s, size_t first_lane, LaneSums* sums) const {
    const KernelBlock::Segment& segment = block_.segments[s];
    addSegment(first_lane, segment, &block_.seen[s * block_.cells], sums);
    if (segment.ends_group) closeGroup(sums);
  }

 private:
  /// Row of the rotation times (x, y, z), for directions.
  HWY_INLINE V rotate(size_t first_lane, int row, const float* v) const {
    const D d;
    const auto plane = [&](int p) { return hn::LoadU(d, block_.rotation[p].data() + first_lane); };
    V sum = hn::Mul(plane(3 * row), hn::Set(d, v[0]));
    sum = hn::MulAdd(plane(3 * row + 1), hn::Set(d, v[1]), sum);
    return hn::MulAdd(plane(3 * row + 2), hn::Set(d, v[2]), sum);
  }

  /// The same plus the translation, in double precision, rounded once.
  HWY_INLINE V transform(size_t first_lane, int row, const double* v) const {
    const D d;
#if HWY_TARGET == HWY_SCALAR
    const D narrow;
#else
    const hn::Half<D> narrow;
#endif
    const hn::Rebind<double, decltype(narrow)> wide;
    const auto lanesFrom = [&](size_t lane) {
      const auto plane = [&](int p) { return hn::LoadU(wide, block_.pose[p].data() + lane); };
      auto sum = hn::Mul(plane(3 * row), hn::Set(wide, v[0]));
      sum = hn::MulAdd(plane(3 * row + 1), hn::Set(wide, v[1]), sum);
      sum = hn::MulAdd(plane(3 * row + 2), hn::Set(wide, v[2]), sum);
      return hn::DemoteTo(narrow, hn::Add(sum, plane(9 + row)));
    };
#if HWY_TARGET == HWY_SCALAR
    (void)d;
    return lanesFrom(first_lane);
#else
    return hn::Combine(d, lanesFrom(first_lane + hn::Lanes(narrow)), lanesFrom(first_lane));
#endif
  }

  /// Whether a sphere is outside the view of all lanes.
  HWY_INLINE bool outsideView(float radius, V x, V y, V z) const {
    const D d;
    const V limit = hn::Set(d, -radius);
    for (const auto& n : camera_.plane) {
      const V distance = hn::MulAdd(hn::Set(d, n[0]), x,
                                    hn::MulAdd(hn::Set(d, n[1]), y, hn::Mul(hn::Set(d, n[2]), z)));
      if (hn::AllTrue(d, hn::Lt(distance, limit))) return true;
    }
    return false;
  }

  /// Visible samples and weight of a segment for each lane. @param seen_row KernelBlock::seen of
  /// the segment
  HWY_INLINE VU seenFrom(size_t first_lane, const uint32_t* seen_row) const {
    const DI di;
    const DU du;
    // Particles are sorted by cell, so the first and the last tell whether all share one cell.
    const int32_t* cell = block_.cell.data() + first_lane;
    return cell[0] == cell[hn::Lanes(du) - 1]
               ? hn::Set(du, seen_row[cell[0]])
               : hn::BitCast(du, hn::GatherIndex(di, reinterpret_cast<const int32_t*>(seen_row),
                                                 hn::LoadU(di, cell)));
  }

  /// Interpolates the table between two rows, two columns and two direction bins.
  /// @param at offset of the upper left pair, bytes; @param frac_x, frac_y, fraction 0 to 1
  /// @param valid lanes next to an ignored pixel are taken out
  HWY_INLINE V scoreAt(VI at, V frac_x, V frac_y, V fraction, hn::Mask<D>* valid) const {
    const D d;
    const DI di;
    const DU du;
    const auto gather = [&](const uint16_t* pairs) {
      return hn::BitCast(du, hn::GatherOffset(di, reinterpret_cast<const int32_t*>(pairs), at));
    };
    const VU top = gather(table_.pairs), bottom = gather(table_.pairs + table_.stride);
    // Bytes from the low one up: (x, bin), (x, next bin), (x + 1, bin), (x + 1, next bin).
    const VU low = hn::Set(du, 0xffu);
    const auto number = [&](VU word) { return hn::ConvertTo(d, hn::BitCast(di, word)); };
    const V a0 = number(hn::And(top, low));
    const V b0 = number(hn::And(hn::ShiftRight<8>(top), low));
    const V a1 = number(hn::And(hn::ShiftRight<16>(top), low));
    const V b1 = number(hn::ShiftRight<24>(top));
    const V c0 = number(hn::And(bottom, low));
    const V e0 = number(hn::And(hn::ShiftRight<8>(bottom), low));
    const V c1 = number(hn::And(hn::ShiftRight<16>(bottom), low));
    const V e1 = number(hn::ShiftRight<24>(bottom));
    if (table_.has_ignored)
      *valid = hn::And(*valid, hn::Gt(hn::Min(hn::Min(a0, a1), hn::Min(c0, c1)), hn::Zero(d)));
    const auto mix = [](V from, V to, V share) {
      return hn::MulAdd(share, hn::Sub(to, from), from);
    };
    const V value_a = mix(mix(a0, a1, frac_x), mix(c0, c1, frac_x), frac_y);
    const V value_b = mix(mix(b0, b1, frac_x), mix(e0, e1, frac_x), frac_y);
    return hn::MulAdd(hn::Set(d, table_.scale), mix(value_a, value_b, fraction),
                      hn::Set(d, table_.offset));
  }

  /// @param seen_row KernelBlock::seen of this segment
  HWY_INLINE void addSegment(size_t first_lane, const KernelBlock::Segment& segment,
                             const uint32_t* seen_row, LaneSums* sums) const {
    const D d;
    const DI di;
    const DU du;
    const V px = transform(first_lane, 0, segment.centre);
    const V py = transform(first_lane, 1, segment.centre);
    const V pz = transform(first_lane, 2, segment.centre);
    if (outsideView(segment.radius, px, py, pz)) return;
    const V tx = rotate(first_lane, 0, segment.tangent);
    const V ty = rotate(first_lane, 1, segment.tangent);
    const V tz = rotate(first_lane, 2, segment.tangent);
    const VU seen = seenFrom(first_lane, seen_row);
    const V segment_weight = hn::Mul(hn::ConvertTo(d, hn::BitCast(di, hn::ShiftRight<16>(seen))),
                                     hn::Set(d, 1 / 65535.0f));
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const V fx = hn::Set(d, camera_.fx), fy = hn::Set(d, camera_.fy);
    const V cx = hn::Set(d, camera_.cx), cy = hn::Set(d, camera_.cy);
    const V last_x = hn::Set(d, camera_.last_x), last_y = hn::Set(d, camera_.last_y);
    const V min_depth = hn::Set(d, camera_.min_depth);
    const V inverse_fade = hn::Set(d, rule_.inverse_fade);
    const V spacing_scale = hn::Set(d, rule_.spacing_scale);
    const float half_bins = 0.5f * static_cast<float>(table_.bins);
    const V rows = hn::Set(d, static_cast<float>(table_.rows));
    const V half = hn::Set(d, 0.5f);
    // Without distortion the image of a line is a line: along the segment the direction, times the
    // depth, is constant.
    const V segment_du = hn::Mul(fx, hn::NegMulAdd(px, tz, hn::Mul(pz, tx)));
    const V segment_dv = hn::Mul(fy, hn::NegMulAdd(py, tz, hn::Mul(pz, ty)));
    const V segment_abs_dv = hn::Abs(segment_dv);
    const V segment_length = hn::Add(hn::Abs(segment_du), segment_abs_dv);
    const DirectionBin segment_bin(d, segment_du, segment_dv, segment_abs_dv, segment_length,
                                   half_bins);
    const V segment_spacing = hn::Mul(segment_length, spacing_scale);

    for (uint32_t left = segment.samples; left != 0; left &= left - 1) {
      const auto i = static_cast<uint32_t>(hwy::Num0BitsBelowLS1Bit_Nonzero32(left));
      const V along = hn::Set(d, block_.along[segment.first + i]);
      const V z = hn::MulAdd(along, tz, pz);
      auto valid =
          hn::And(hn::RebindMask(d, hn::TestBit(seen, hn::Set(du, 1u << i))), hn::Gt(z, min_depth));
      if (hn::AllFalse(d, valid)) continue;
      const V iz = reciprocal(d, hn::Max(z, min_depth));
      V xn = hn::Mul(hn::MulAdd(along, tx, px), iz);
      V yn = hn::Mul(hn::MulAdd(along, ty, py), iz);
      // An edge seen end-on has no direction in the image: it fades out. In the robust model the
      // measure is the distance of neighbouring samples in the image.
      V spacing = hn::Mul(segment_spacing, iz);
      DirectionBin bin = segment_bin;
      if constexpr (kModel != static_cast<int>(DistortionModel::kNone)) {
        // Direction of the projected edge, up to the factor iz.
        const V a = hn::NegMulAdd(xn, tz, tx), b = hn::NegMulAdd(yn, tz, ty);
        const V r2 = hn::MulAdd(xn, xn, hn::Mul(yn, yn));
        valid = hn::And(valid, hn::Le(r2, hn::Set(d, camera_.max_radius2)));
        const Distorted q = distort<kModel>(d, xn, yn, r2, camera_);
        xn = q.x;
        yn = q.y;
        const V du_image = hn::Mul(fx, hn::MulAdd(q.j00, a, hn::Mul(q.j01, b)));
        const V dv_image = hn::Mul(fy, hn::MulAdd(q.j01, a, hn::Mul(q.j11, b)));
        const V abs_dv = hn::Abs(dv_image);
        const V length = hn::Add(hn::Abs(du_image), abs_dv);
        bin = DirectionBin(d, du_image, dv_image, abs_dv, length, half_bins);
        spacing = hn::Mul(length, spacing_scale);
      }
      const V u = hn::MulAdd(fx, xn, cx), v = hn::MulAdd(fy, yn, cy);
      const V border = hn::Min(hn::Min(u, hn::Sub(last_x, u)), hn::Min(v, hn::Sub(last_y, v)));
      valid = hn::And(valid, hn::Ge(border, zero));
      if (hn::AllFalse(d, valid)) continue;
      V weight = hn::Mul(segment_weight, hn::Min(one, hn::Mul(border, inverse_fade)));

      weight = hn::Mul(weight, hn::Min(one, rule_.paper ? spacing : hn::Mul(spacing, iz)));
      const RoundedDown x(d, hn::Sub(u, half)), y(d, hn::Sub(v, half));
      // Not u - x: this has one rounding less.
      const V frac_x = hn::MulAdd(fx, xn, hn::Sub(cx, x.value));
      const V frac_y = hn::MulAdd(fy, yn, hn::Sub(cy, y.value));
      const V row = hn::MulAdd(bin.lower, rows, y.value);  // exact: below 2^22
      const VI at = hn::IfThenElseZero(hn::RebindMask(di, valid),
                                       byteOffset(RoundedDown::bits(d, row), x.bits(d)));
      const V score = scoreAt(at, frac_x, frac_y, bin.fraction, &valid);
      // The score of an invalid sample may not be finite.
      sums->group_score =
          hn::IfThenElse(valid, hn::MulAdd(weight, score, sums->group_score), sums->group_score);
      sums->group_weight =
          hn::IfThenElse(valid, hn::Add(sums->group_weight, weight), sums->group_weight);
    }
  }

  /// Offset in the table in bytes, from the biased bits of row and column.
  HWY_INLINE VI byteOffset(VI row, VI x) const {
    const DI di;
    const auto stride = static_cast<uint32_t>(2 * table_.stride);
    const uint32_t bias = RoundedDown::kBias * (stride + 2);
    const VI offset =
        hn::Add(hn::Mul(row, hn::Set(di, static_cast<int32_t>(stride))), hn::Add(x, x));
    return hn::Sub(offset, hn::Set(di, static_cast<int32_t>(bias)));
  }

  HWY_INLINE void closeGroup(LaneSums* sums) const {
    const D d;
    const V one = hn::Set(d, 1.0f);
    if (rule_.paper) {
      // Eq. (2); a line that just fades in counts partly.
      sums->line_sum.add(
          hn::Mul(sums->group_score, reciprocal(d, hn::Max(one, sums->group_weight))));
      sums->line_count = hn::Add(sums->line_count, hn::Min(one, sums->group_weight));
    } else {
      const V saturation = hn::Mul(sums->group_weight, hn::Set(d, rule_.inverse_saturation));
      const V share = reciprocal(d, hn::Add(saturation, one));
      sums->line_sum.add(hn::Mul(sums->group_score, share));
      sums->line_count = hn::MulAdd(saturation, share, sums->line_count);
    }
    sums->total_weight = hn::Add(sums->total_weight, sums->group_weight);
    sums->group_score = sums->group_weight = hn::Zero(d);
  }

  const KernelBlock& block_;
  const KernelCamera& camera_;
  const KernelTable& table_;
  const KernelLineRule& rule_;
};

/// Sums of a vector of particles in memory.
struct StoredSums {
  static constexpr size_t kWords = 6;
  static HWY_INLINE LaneSums load(const float* from) {
    const D d;
    const size_t n = hn::Lanes(d);
    LaneSums sums(d);
    sums.group_score = hn::LoadU(d, from);
    sums.group_weight = hn::LoadU(d, from + n);
    sums.line_sum.sum = hn::LoadU(d, from + 2 * n);
    sums.line_sum.error = hn::LoadU(d, from + 3 * n);
    sums.line_count = hn::LoadU(d, from + 4 * n);
    sums.total_weight = hn::LoadU(d, from + 5 * n);
    return sums;
  }
  static HWY_INLINE void store(const LaneSums& sums, float* to) {
    const D d;
    const size_t n = hn::Lanes(d);
    hn::StoreU(sums.group_score, d, to);
    hn::StoreU(sums.group_weight, d, to + n);
    hn::StoreU(sums.line_sum.sum, d, to + 2 * n);
    hn::StoreU(sums.line_sum.error, d, to + 3 * n);
    hn::StoreU(sums.line_count, d, to + 4 * n);
    hn::StoreU(sums.total_weight, d, to + 5 * n);
  }
};

template <int kModel>
void scoreBlock(const KernelBlock& block, const KernelCamera& camera, const KernelTable& table,
                const KernelLineRule& rule, KernelResult* results) {
  // One segment at a time for all particles: together they touch one small part of the table,
  // which then stays in the fastest cache.
  const LaneScorer<kModel> scorer(block, camera, table, rule);
  const size_t n = hn::Lanes(D()), vectors = (block.particles + n - 1) / n;
  std::vector<float> stored(vectors * StoredSums::kWords * n, 0.0f);
  for (size_t s = 0; s < block.segments.size(); ++s)
    for (size_t k = 0; k < vectors; ++k) {
      float* state = &stored[k * StoredSums::kWords * n];
      LaneSums sums = StoredSums::load(state);
      scorer.add(s, k * n, &sums);
      StoredSums::store(sums, state);
    }
  for (size_t p = 0; p < block.particles; ++p) {
    const float* state = &stored[p / n * StoredSums::kWords * n + p % n];
    results[p] = {static_cast<double>(state[2 * n]) + state[3 * n], state[5 * n], state[4 * n]};
  }
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
