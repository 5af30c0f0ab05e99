/// Interface between the CPU backend and its vectorised kernel. Internal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace edge_mcl {

/// One block of work: particles and all the samples that any of them may see.
///
/// The samples of a segment lie on a straight line: a sample is centre + along * tangent. The
/// centre goes to the camera frame in double precision, once per particle and segment; what follows
/// per sample is short, and single precision is enough.
struct KernelBlock {
  struct Segment {
    double centre[3];  // map frame, metres
    float tangent[3];  // map axes, unit
    float radius;
    uint32_t first;    // into along
    uint32_t samples;  // bit i: sample i is seen from at least one cell
    bool ends_group;
  };
  const float* along = nullptr;  // of every sample of the model
  std::vector<Segment> segments;
  /// (segment, cell): low half, bit i: sample i is seen from the cell; high half: weight of the
  /// segment there, of 65535.
  std::vector<uint32_t> seen;
  uint32_t cells = 0;
  // Particles: cell; rotation map->camera (row-major, 9 planes) and translation (3 planes); padded
  // to kLanePadding by copies of the last particle.
  static constexpr size_t kLanePadding = 16;
  size_t particles = 0;
  std::vector<int32_t> cell;
  std::vector<double> pose[12];
  std::vector<float> rotation[9];  // of pose, rounded
};

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

/// See ScoreTable.
struct KernelTable {
  const uint16_t* pairs;
  int stride, rows, bins;
  bool has_ignored;
  float scale, offset;
};

struct KernelLineRule {
  bool paper;
  float inverse_saturation;
  float inverse_fade;
  /// See spacingScale().
  float spacing_scale;
};

/// Sums per particle.
struct KernelResult {
  double line_sum;
  float sample_weight;
  float line_count;
};

/// Scores all particles of a block.
void runKernel(const KernelBlock& block, const KernelCamera& camera, const KernelTable& table,
               const KernelLineRule& rule, KernelResult* results);

/// Instruction set in use, e.g. "AVX3".
const char* kernelTargetName();

}  // namespace edge_mcl
