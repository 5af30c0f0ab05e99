/// Log-likelihood of one particle by warps of 32 lanes, a lane per normal: the body of the CUDA
/// kernel, for host and device.
#pragma once

#include "edge_mcl/gpu/math/sample_math.h"

namespace edge_mcl::gpu {

constexpr int kLanes = 32;  ///< of a warp
/// A cell's lines are dealt out to so many parts, which warps can work on side by side.
constexpr int kParts = 4;

/// A particle: camera pose in the map and the visibility cell it is in.
struct Particle {
  double rotation[9];  ///< map from camera, row-major
  double position[3];  ///< of the camera, map, metres
  uint32_t cell;
  uint32_t unused;
};

/// A visible sample of the model, relative to its cell's origin.
struct alignas(16) Sample {
  float centre[3];   ///< of its segment, metres, map axes
  float along;       ///< position along the tangent from there, metres
  float tangent[3];  ///< unit, map axes
  float weight;      ///< how far the cell's middle sees it (robust)
};
static_assert(sizeof(Sample) == 32, "two loads of 16 bytes");

/// Samples that the lanes of a warp work on at once; those of a line lie side by side.
struct alignas(16) Chunk {
  float centre[3], radius;  ///< of a sphere around them, metres, relative to the cell's origin
  uint32_t heads;           ///< bit i: sample i is of another line than sample i - 1
  uint32_t count;
  uint32_t first_line, last_line;  ///< of the first and last sample, numbers within the cell
};
static_assert(sizeof(Chunk) == 32, "two loads of 16 bytes");

/// A visibility cell. Its chunk c has the samples from 32 c on.
struct Cell {
  double origin[3];  ///< map, metres
  uint32_t first_chunk;
  uint32_t chunk_count;
  /// Part p has the cell's chunks from part_end[p - 1] (0) to part_end[p]. No line is in two parts.
  uint32_t part_end[kParts];
};

/// From sums over lines to the log-likelihood, see edge_mcl::combineLines.
struct Combination {
  double scale, line_correlation;  ///< robust
  double log_alpha, k;             ///< paper
};

struct Result {
  double log_likelihood;
  float sample_weight, line_count;
};

/// Element `i` (0 to 8 rotation, 9 to 11 translation) of a particle's pose relative to its cell.
EDGE_MCL_DEVICE_FUNCTION void fillPose(const Particle& particle, const Cell& cell, int i,
                                       Pose* pose) {
  if (i < 9) {
    const double value = particle.rotation[3 * (i % 3) + i / 3];  // transposed
    pose->rotation[i] = static_cast<float>(value);
    pose->rotation_rest[i] = static_cast<float>(value - pose->rotation[i]);
    return;
  }
  double sum = 0;
  for (int k = 0; k < 3; ++k)
    sum += particle.rotation[3 * k + i - 9] * (cell.origin[k] - particle.position[k]);
  pose->translation[i - 9] = static_cast<float>(sum);
  pose->translation_rest[i - 9] = static_cast<float>(sum - pose->translation[i - 9]);
}

/// Score and weight of a lane or of a line.
struct PartialLine {
  float score, weight;
};

/// One sample's contribution to its line.
EDGE_MCL_DEVICE_FUNCTION PartialLine scoreOf(const Camera& camera, const Table& table,
                                             const Quad* quads, const Rule& rule, const Pose& pose,
                                             const Sample& sample) {
  const SampleScore score =
      scoreSample(camera, table, quads, rule, transformPoint(pose, sample.centre),
                  rotateDirection(pose, sample.tangent), sample.along);
  const float weight = (rule.paper ? 1.0f : sample.weight) * score.weight;
  return {weight * score.score, weight};
}

/// Whether some of the chunk may be in the image: its sphere against the cone around the optical
/// axis that holds the image.
EDGE_MCL_DEVICE_FUNCTION bool mayBeInView(const Camera& camera, const Pose& pose,
                                          const Chunk& chunk) {
  const Vector3 c = transformPoint(pose, chunk.centre);
  const float across = sqrtf(fmaf(c.x, c.x, c.y * c.y));
  const float square = fmaf(c.z, c.z, across * across);
  if (square <= chunk.radius * chunk.radius) return true;
  // Signed distance from the cone's surface, seen from outside positive. Where the apex is nearest
  // the distance is larger than that.
  return fmaf(across, camera.view_cos, -c.z * camera.view_sin) <= chunk.radius;
}

/// Sums over lines; the rounding error of the sum is carried along (Knuth's two-sum).
struct LineSums {
  float sum, error, count, weight;
};

EDGE_MCL_DEVICE_FUNCTION void addCompensated(float value, LineSums* sums) {
  const float total = sums->sum + value, part = total - sums->sum;
  sums->error += (sums->sum - (total - part)) + (value - part);
  sums->sum = total;
}

EDGE_MCL_DEVICE_FUNCTION void closeLine(const Rule& rule, const PartialLine& line, LineSums* sums) {
  if (rule.paper) {
    // Eq. (2); a line that just fades in counts partly.
    addCompensated(line.score / fmaxf(1.0f, line.weight), sums);
    sums->count += fminf(1.0f, line.weight);
  } else {
    const float saturation = line.weight * rule.inverse_saturation;
    const float share = 1 / (saturation + 1);
    addCompensated(line.score * share, sums);
    sums->count = fmaf(saturation, share, sums->count);
  }
  sums->weight += line.weight;
}

/// The line that is not finished at the end of a chunk.
struct OpenLine {
  PartialLine sum;
  uint32_t line;
};
constexpr uint32_t kNoLine = 0xffffffffu;

/// From sums over all lines to the result.
EDGE_MCL_DEVICE_FUNCTION Result combine(const Rule& rule, const Combination& combination,
                                        double sum, float lines, float weight) {
  double value = 0;
  if (rule.paper)
    value = combination.log_alpha + (lines > 0 ? combination.k * sum / lines : 0);
  else
    value = combination.scale * sum /
            (1 + combination.line_correlation * fmax(0.0, static_cast<double>(lines) - 1));
  return {value, weight, lines};
}

}  // namespace edge_mcl::gpu
