/// Computes the score of one model sample for one camera pose in single precision, on host and
/// device. Every sum of a product is an explicit fmaf, so that both compute the same bits.
///
/// The header needs only a C++17 compiler. With nvcc the functions are also device functions.
#pragma once

#include <cmath>
#include <cstdint>

#if defined(__CUDACC__)
#define EDGE_MCL_DEVICE_FUNCTION __host__ __device__ inline
#else
#define EDGE_MCL_DEVICE_FUNCTION inline
#endif

namespace edge_mcl::gpu {

/// Values as in edge_mcl::DistortionModel.
enum Distortion : int32_t { kNone, kPlumbBob, kRationalPolynomial, kEquidistant };

/// Intrinsics, see edge_mcl::CameraModel.
struct Camera {
  float fx, fy, cx, cy;
  float last_x, last_y;      ///< width - 1, height - 1
  float max_radius2;         ///< largest squared length of (X/Z, Y/Z) with monotone distortion
  float min_depth;           ///< metres
  float view_sin, view_cos;  ///< of the half angle of the cone around the axis that has the image
  int32_t distortion;        ///< Distortion
  float k[8];                ///< coefficients of the distortion
};

/// Geometry of the score table, see edge_mcl::ScoreTable.
struct Table {
  int32_t width, height, bins;
  int32_t has_ignored;
  float scale, offset;
};

/// Element of the table on the device. It holds ScoreTable::pairs of a pixel (low half) and of its
/// right neighbour (high half), for the pixel's row and for the row below. So a sample needs one
/// look-up; separate look-ups would limit the speed of the kernel. Order: (bin, y, x), row-major.
struct alignas(8) Quad {
  uint32_t top, bottom;
};

/// Parameters for the sums over samples and lines.
struct Rule {
  int32_t paper;             ///< 1: the paper's model, 0: robust model
  float inverse_saturation;  ///< robust model: 1 / likelihood.line_saturation
  float inverse_fade;        ///< 1 / width of the fade at the image border, pixels
  float spacing_scale;       ///< see edge_mcl::spacingScale
};

/// T_camera_map relative to the cell's origin. Every number is two floats (value and rest), which
/// keep 48 bits.
struct Pose {
  float rotation[9], rotation_rest[9];        ///< row-major
  float translation[3], translation_rest[3];  ///< of the cell's origin
};

struct Vector3 {
  float x, y, z;
};

struct SampleScore {
  float weight;  ///< 0 when the sample is not in the image or ignored
  float score;
};

EDGE_MCL_DEVICE_FUNCTION float dotRow(const float* row, const float* v) {
  return fmaf(row[2], v[2], fmaf(row[1], v[1], row[0] * v[0]));
}

/// Transforms a point (map axes, relative to the cell's origin, metres) into the camera frame.
EDGE_MCL_DEVICE_FUNCTION Vector3 transformPoint(const Pose& pose, const float* point) {
  float out[3] = {0, 0, 0};
  for (int r = 0; r < 3; ++r) {
    const float rest = dotRow(pose.rotation_rest + 3 * r, point) + pose.translation_rest[r];
    out[r] = dotRow(pose.rotation + 3 * r, point) + (pose.translation[r] + rest);
  }
  return {out[0], out[1], out[2]};
}

/// Rotates a direction from map axes into the camera frame.
EDGE_MCL_DEVICE_FUNCTION Vector3 rotateDirection(const Pose& pose, const float* direction) {
  return {dotRow(pose.rotation, direction), dotRow(pose.rotation + 3, direction),
          dotRow(pose.rotation + 6, direction)};
}

/// Normalised image point after distortion, and the Jacobian of the distortion (symmetric).
struct Distorted {
  float x, y, j00, j01, j11;
};

EDGE_MCL_DEVICE_FUNCTION Distorted distortEquidistant(const Camera& camera, float x, float y,
                                                      float r2) {
  const float* k = camera.k;
  const float r2_safe = fmaxf(r2, 1e-14f);
  const float r = sqrtf(r2_safe), theta = atanf(r), t2 = theta * theta;
  const float poly = fmaf(t2, fmaf(t2, fmaf(t2, fmaf(t2, k[3], k[2]), k[1]), k[0]), 1.0f);
  const float slope =
      fmaf(t2, fmaf(t2, fmaf(t2, fmaf(t2, 9 * k[3], 7 * k[2]), 5 * k[1]), 3 * k[0]), 1.0f);
  const float scale = theta * poly / r;
  const float s = (slope / (1 + r2) - scale) / r2_safe;
  return {x * scale, y * scale, fmaf(s * x, x, scale), s * x * y, fmaf(s * y, y, scale)};
}

EDGE_MCL_DEVICE_FUNCTION Distorted distortPolynomial(const Camera& camera, float x, float y,
                                                     float r2) {
  const float* k = camera.k;
  float factor = fmaf(r2, fmaf(r2, fmaf(r2, k[4], k[1]), k[0]), 1.0f);
  float slope = fmaf(r2, fmaf(r2, 3 * k[4], 2 * k[1]), k[0]);  // derivative by r2
  if (camera.distortion == kRationalPolynomial) {
    const float below = fmaf(r2, fmaf(r2, fmaf(r2, k[7], k[6]), k[5]), 1.0f);
    const float below_slope = fmaf(r2, fmaf(r2, 3 * k[7], 2 * k[6]), k[5]);
    slope = fmaf(slope, below, -factor * below_slope) / (below * below);
    factor /= below;
  }
  const float p1 = k[2], p2 = k[3], xy = x * y, xx = x * x, yy = y * y;
  return {fmaf(x, factor, fmaf(2 * p1, xy, p2 * fmaf(2.0f, xx, r2))),
          fmaf(y, factor, fmaf(p1, fmaf(2.0f, yy, r2), 2 * p2 * xy)),
          fmaf(2 * slope, xx, factor + fmaf(2 * p1, y, 6 * p2 * x)),
          fmaf(2 * slope, xy, fmaf(2 * p1, x, 2 * p2 * y)),
          fmaf(2 * slope, yy, factor + fmaf(2 * p2, x, 6 * p1 * y))};
}

/// Interpolates between the two bytes of a pair, which belong to neighbouring direction bins.
EDGE_MCL_DEVICE_FUNCTION float mixPair(uint32_t pair, float share) {
  const float here = static_cast<float>(pair & 0xffu);
  return fmaf(share, static_cast<float>(pair >> 8 & 0xffu) - here, here);
}

/// Whether one of two pixels is ignored (byte 0).
EDGE_MCL_DEVICE_FUNCTION bool isIgnored(uint32_t two_pairs) {
  return !(two_pairs & 0xffu) || !(two_pairs & 0xff0000u);
}

EDGE_MCL_DEVICE_FUNCTION Quad loadQuad(const Quad* at) {
#if defined(__CUDA_ARCH__)
  const uint2 both = __ldg(reinterpret_cast<const uint2*>(at));
  return {both.x, both.y};
#else
  return *at;
#endif
}

/// Projects a sample and looks up its score. @param centre, tangent camera frame, metres.
/// @param along metres from the segment's centre.
EDGE_MCL_DEVICE_FUNCTION SampleScore scoreSample(const Camera& camera, const Table& table,
                                                 const Quad* quads, const Rule& rule,
                                                 const Vector3& centre, const Vector3& tangent,
                                                 float along) {
  const SampleScore none{0, 0};
  const float z = fmaf(along, tangent.z, centre.z);
  if (!(z > camera.min_depth)) return none;
  const float iz = 1 / z;
  float x = fmaf(along, tangent.x, centre.x) * iz, y = fmaf(along, tangent.y, centre.y) * iz;
  // Direction of the projected edge in the image plane, multiplied by the depth.
  float a = fmaf(-x, tangent.z, tangent.x), b = fmaf(-y, tangent.z, tangent.y);
  if (camera.distortion != kNone) {
    const float r2 = fmaf(x, x, y * y);
    if (!(r2 <= camera.max_radius2)) return none;
    const Distorted q = camera.distortion == kEquidistant ? distortEquidistant(camera, x, y, r2)
                                                          : distortPolynomial(camera, x, y, r2);
    x = q.x;
    y = q.y;
    const float a_distorted = fmaf(q.j00, a, q.j01 * b);
    b = fmaf(q.j01, a, q.j11 * b);
    a = a_distorted;
  }
  const float u = fmaf(camera.fx, x, camera.cx), v = fmaf(camera.fy, y, camera.cy);
  const float border = fminf(fminf(u, camera.last_x - u), fminf(v, camera.last_y - v));
  if (!(border >= 0)) return none;
  const float du = camera.fx * a, dv = camera.fy * b;
  const float length = fabsf(du) + fabsf(dv);
  const float spacing = length * rule.spacing_scale * (rule.paper ? 1.0f : iz);
  const float weight = fminf(1.0f, border * rule.inverse_fade) * fminf(1.0f, spacing);

  // Direction of the undirected edge as position on the unit diamond |du| + |dv| = 1.
  const float ratio = fabsf(dv) / fmaxf(length, 1e-20f);
  const float diamond = du * dv < 0 ? 2 - ratio : ratio;
  const float bin = diamond * (0.5f * static_cast<float>(table.bins));
  const int bin_floor = static_cast<int>(fminf(bin, static_cast<float>(table.bins) - 0.5f));
  const float bin_share = bin - static_cast<float>(bin_floor);
  const int ix = static_cast<int>(u), iy = static_cast<int>(v);
  // This has one rounding less than u - ix.
  const float share_x = fmaf(camera.fx, x, camera.cx - static_cast<float>(ix));
  const float share_y = fmaf(camera.fy, y, camera.cy - static_cast<float>(iy));
  const Quad quad =
      loadQuad(quads + (static_cast<int64_t>(bin_floor) * table.height + iy) * table.width + ix);
  if (table.has_ignored && (isIgnored(quad.top) || isIgnored(quad.bottom))) return none;
  const float left_top = mixPair(quad.top, bin_share);
  const float top = fmaf(share_x, mixPair(quad.top >> 16, bin_share) - left_top, left_top);
  const float left_bottom = mixPair(quad.bottom, bin_share);
  const float bottom =
      fmaf(share_x, mixPair(quad.bottom >> 16, bin_share) - left_bottom, left_bottom);
  return {weight, fmaf(table.scale, fmaf(share_y, bottom - top, top), table.offset)};
}

}  // namespace edge_mcl::gpu
