/// Log-likelihood of one particle by teams of sixteen lanes, a lane per normal: the body of the
/// CUDA kernel, for host and device.
#pragma once

#include "sample_math.h"

namespace edge_mcl::gpu {

constexpr int kTeamLanes = 16;  ///< samples of a segment

/// A particle: camera pose in the map and the visibility cell it is in.
struct Particle {
  double rotation[9];  ///< map from camera, row-major
  double position[3];  ///< of the camera, map, metres
  uint32_t cell;
  uint32_t unused;
};

/// A visibility cell: its segments, grouped into lines (equation 2).
struct Cell {
  double origin[3];      ///< map, metres; the segments' centres are relative to it
  uint32_t first_group;  ///< into the array of group ends
  uint32_t group_count;
  uint32_t first_segment;
  uint32_t unused;
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

/// Score and weight of a lane or of a whole line.
struct PartialLine {
  float score, weight;
};

/// Whether the lane's sample is visible and not thinned out.
EDGE_MCL_DEVICE_FUNCTION bool isUsed(const Rule& rule, const Segment& segment, int lane) {
  if (!(segment.seen >> lane & 1u)) return false;
  return rule.thinning <= 1 || (segment.first + lane) % rule.thinning == 0;
}

/// Adds the lane's sample of one segment.
EDGE_MCL_DEVICE_FUNCTION void addSample(const Camera& camera, const Table& table,
                                        const uint16_t* pairs, const Rule& rule, const Pose& pose,
                                        const Segment& segment, const float* along, int lane,
                                        PartialLine* sum) {
  if (!isUsed(rule, segment, lane)) return;
  const SampleScore sample =
      scoreSample(camera, table, pairs, rule, transformPoint(pose, segment.centre),
                  rotateDirection(pose, segment.tangent), along[segment.first + lane]);
  const float facing = rule.paper ? 1.0f : static_cast<float>(segment.seen >> 16) * (1 / 65535.0f);
  const float weight = facing * sample.weight;
  sum->score = fmaf(weight, sample.score, sum->score);
  sum->weight += weight;
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

/// Adds the sums of the teams of one particle, in their order.
EDGE_MCL_DEVICE_FUNCTION Result combineTeams(const Rule& rule, const Combination& combination,
                                             const LineSums* teams, int count) {
  double sum = 0;
  float lines = 0, weight = 0;
  for (int i = 0; i < count; ++i) {
    sum += static_cast<double>(teams[i].sum) + teams[i].error;
    lines += teams[i].count;
    weight += teams[i].weight;
  }
  double value = 0;
  if (rule.paper)
    value = combination.log_alpha + (lines > 0 ? combination.k * sum / lines : 0);
  else
    value = combination.scale * sum /
            (1 + combination.line_correlation * fmax(0.0, static_cast<double>(lines) - 1));
  return {value, weight, lines};
}

}  // namespace edge_mcl::gpu
