/// Interface between the CPU backend and its vectorised kernel. Internal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace edge_mcl {

/// One block of work: particles, and all samples that any of them may see.
///
/// The samples of a segment lie on a straight line: a sample is centre + along * tangent. The
/// centre goes to the camera frame in double precision, once per particle and segment. The way from
/// the centre to a sample is short, so single precision is enough for it.
struct KernelBlock {
  struct Segment {
    double centre[3];  // map frame, metres
    float tangent[3];  // map axes, unit
    float radius;      // of the sphere about the centre that holds all samples, metres
    uint32_t first;    // index of the first sample in along
    uint32_t samples;  // bit i: sample i is visible from at least one cell
    bool ends_group;   // last segment of its group
  };
  // Of every sample of the model: metres from the centre of its segment.
  const float* along = nullptr;
  std::vector<Segment> segments;
  /// Visible samples by (segment, cell). Low half, bit i: sample i is visible from the cell. High
  /// half: weight of the segment there, in units of 1/65535.
  std::vector<uint32_t> seen;
  uint32_t cells = 0;
  // Arrays over the particles: cell; rotation map->camera (row-major, 9 arrays) and translation (3
  // arrays). They are padded to a multiple of kLanePadding by copies of the last particle.
  static constexpr size_t kLanePadding = 16;
  size_t particles = 0;
  std::vector<int32_t> cell;
  std::vector<double> pose[12];
  std::vector<float> rotation[9];  // of pose, rounded
};

/// A camera in single precision.
struct KernelCamera {
  float fx, fy, cx, cy;
  float last_x, last_y;  // width - 1, height - 1
  float max_radius2;
  float min_depth;
  /// Inward unit normals of the four planes that bound the view, camera frame.
  float plane[4][3];
  int distortion;  // DistortionModel
  float k[8];
};

/// A score table as the kernel reads it, see ScoreTable.
struct KernelTable {
  const uint16_t* pairs;
  int stride, rows, bins;
  bool has_ignored;
  float scale, offset;
};

/// Numbers for adding up samples and lines, from LikelihoodParameters.
struct KernelLineRule {
  bool paper;                ///< equations (2) and (3) instead of the robust model
  float inverse_saturation;  ///< 1 / line_saturation
  float inverse_fade;        ///< 1 / border_fade
  /// See spacingScale().
  float spacing_scale;
};

/// Sums of one particle.
struct KernelResult {
  double line_sum;      ///< sum of the scores of all lines
  float sample_weight;  ///< see PoseScore::sample_weight
  float line_count;     ///< see PoseScore::line_count
};

/// Scores all particles of a block.
void runKernel(const KernelBlock& block, const KernelCamera& camera, const KernelTable& table,
               const KernelLineRule& rule, KernelResult* results);

/// Name of the instruction set in use, e.g. "AVX3".
const char* kernelTargetName();

}  // namespace edge_mcl
