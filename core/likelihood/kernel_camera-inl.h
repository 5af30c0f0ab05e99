/// Distortion of the kernel's camera, for a vector of points at a time.
///
/// This file is included once per instruction set, hence the include guard that toggles.
#if defined(EDGE_MCL_CORE_KERNEL_CAMERA_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EDGE_MCL_CORE_KERNEL_CAMERA_INL_H
#undef EDGE_MCL_CORE_KERNEL_CAMERA_INL_H
#else
#define EDGE_MCL_CORE_KERNEL_CAMERA_INL_H
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/likelihood/cpu_kernel.h"

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

/// Computes 1/v to within two units in the last place.
HWY_INLINE V reciprocal(D d, V v) {
  const V guess = hn::ApproximateReciprocal(v);
  const V once = hn::MulAdd(guess, hn::NegMulAdd(v, guess, hn::Set(d, 1.0f)), guess);
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  return once;  // one step refines 14 bits to all bits
#else
  return hn::MulAdd(once, hn::NegMulAdd(v, once, hn::Set(d, 1.0f)), once);
#endif
}

/// Normalised image coordinates after distortion, and the symmetric Jacobian of the distortion.
struct Distorted {
  V x, y, j00, j01, j11;
};

/// Distorts normalised image coordinates (x, y), with r2 = x^2 + y^2.
/// @tparam kModel DistortionModel.
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

}  // namespace HWY_NAMESPACE
}  // namespace edge_mcl
HWY_AFTER_NAMESPACE();

#endif
