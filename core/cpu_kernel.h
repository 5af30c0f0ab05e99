/// Interface between the CPU backend and its vectorised kernel. Internal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace edge_mcl {

/// One block of work: particles that share a list of samples. Coordinates are relative to an
/// origin near the cameras, so that single precision is enough.
struct KernelBlock {
  struct Segment {
    float tx, ty, tz;  // tangent, map axes
    float weight;
    uint32_t first, count;
    bool ends_group;
  };
  // Samples, structure of arrays.
  std::vector<float> x, y, z;
  std::vector<Segment> segments;
  // Particles: rotation map->camera (row-major, 9 planes) and translation (3 planes), padded to
  // kLanePadding by copies of the last particle.
  static constexpr size_t kLanePadding = 16;
  size_t particles = 0;
  std::vector<float> pose[12];
};

struct KernelCamera {
  float fx, fy, cx, cy;
  float last_x, last_y;  // width - 1, height - 1
  float max_radius2;
  float min_depth;
  int distortion;  // DistortionModel
  float k[8];
};

struct KernelTable {
  const uint32_t* words;
  int width, height, bins;
  float scale, offset;
};

struct KernelLineRule {
  bool paper;
  float inverse_saturation;
  float inverse_fade;
  /// Robust model: focal length * sample step / correlation length; a sample weighs as much as
  /// the pixels to its neighbour are new.
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
