/// Computes the log-likelihood of one particle with warps of 32 lanes, one lane per sample. These
/// functions are the body of the CUDA kernel, for host and device.
///
/// "Line" in gpu/ means the line of equation (2): a group of model lines that are judged together.
#pragma once

#include "edge_mcl/gpu/math/sample_math.h"

namespace edge_mcl::gpu {

constexpr int kLanes = 32;  ///< lanes of a warp
/// Number of parts into which the lines of a cell are divided, so that several warps can share
/// them.
constexpr int kParts = 4;

/// A particle: the camera pose in the map and the visibility cell of its position.
struct Particle {
  double rotation[9];  ///< rotation of T_map_camera, row-major
  double position[3];  ///< of the camera, map, metres
  uint32_t cell;
  uint32_t unused;
};

/// A visible sample of the model, relative to its cell's origin.
struct alignas(16) Sample {
  float centre[3];   ///< centre of its segment, metres, map axes
  float along;       ///< position along the tangent from the centre, metres
  float tangent[3];  ///< unit, map axes
  float weight;      ///< VisibleSet::facingWeight at the cell's centre (robust model only)
};
static_assert(sizeof(Sample) == 32, "two loads of 16 bytes");

/// Up to kLanes samples that the lanes of a warp score at once. Samples of a line lie side by side.
struct alignas(16) Chunk {
  float centre[3], radius;  ///< sphere around the samples, metres, relative to the cell's origin
  uint32_t heads;           ///< bit i: sample i belongs to another line than sample i - 1
  uint32_t count;           ///< number of samples
  uint32_t first_line, last_line;  ///< lines of the first and last sample, numbers in the cell
};
static_assert(sizeof(Chunk) == 32, "two loads of 16 bytes");

/// A visibility cell. Chunk number c of all chunks has the samples from number 32 c on.
struct Cell {
  double origin[3];      ///< map, metres
  uint32_t first_chunk;  ///< number of its first chunk
  uint32_t chunk_count;
  /// Part p has the cell's chunks from part_end[p - 1] (0 for p = 0) to part_end[p] - 1. No line is
  /// in two parts.
  uint32_t part_end[kParts];
};

/// Parameters that turn the sum over lines into the log-likelihood, see edge_mcl::combineLines.
struct Combination {
  double scale, line_correlation;  ///< robust model
  double log_alpha, k;             ///< paper's model
};

/// Result of one particle, see edge_mcl::PoseScore.
struct Result {
  double log_likelihood;
  float sample_weight, line_count;
};

/// Sets element `i` of a particle's pose relative to its cell: 0 to 8 rotation, 9 to 11
/// translation.
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

/// Weighted score and weight, of one lane or of a line.
struct PartialLine {
  float score, weight;
};

/// Returns the contribution of one sample to its line.
EDGE_MCL_DEVICE_FUNCTION PartialLine scoreOf(const Camera& camera, const Table& table,
                                             const Quad* quads, const Rule& rule, const Pose& pose,
                                             const Sample& sample) {
  const SampleScore score =
      scoreSample(camera, table, quads, rule, transformPoint(pose, sample.centre),
                  rotateDirection(pose, sample.tangent), sample.along);
  const float weight = (rule.paper ? 1.0f : sample.weight) * score.weight;
  return {weight * score.score, weight};
}

/// Whether a part of the chunk may be in the image. Compares the chunk's sphere with the cone
/// around the optical axis that contains the image.
EDGE_MCL_DEVICE_FUNCTION bool mayBeInView(const Camera& camera, const Pose& pose,
                                          const Chunk& chunk) {
  const Vector3 c = transformPoint(pose, chunk.centre);
  const float across = sqrtf(fmaf(c.x, c.x, c.y * c.y));
  const float square = fmaf(c.z, c.z, across * across);
  if (square <= chunk.radius * chunk.radius) return true;
  // Signed distance from the surface of the cone, positive outside. Where the apex is the nearest
  // point, the true distance is larger, so the test stays on the safe side.
  return fmaf(across, camera.view_cos, -c.z * camera.view_sin) <= chunk.radius;
}

/// Sums over lines. `error` collects the rounding errors of `sum` (Knuth's two-sum).
struct LineSums {
  float sum, error, count, weight;
};

/// Adds a value and its rounding error.
EDGE_MCL_DEVICE_FUNCTION void addCompensated(float value, LineSums* sums) {
  const float total = sums->sum + value, part = total - sums->sum;
  sums->error += (sums->sum - (total - part)) + (value - part);
  sums->sum = total;
}

/// Adds a finished line to the sums.
EDGE_MCL_DEVICE_FUNCTION void closeLine(const Rule& rule, const PartialLine& line, LineSums* sums) {
  if (rule.paper) {
    // Equation (2). A line whose weight is below 1, because it fades in, counts partly.
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

/// A line that is not finished at the end of a chunk.
struct OpenLine {
  PartialLine sum;
  uint32_t line;
};
constexpr uint32_t kNoLine = 0xffffffffu;

/// Computes the result from the sums over all lines.
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
