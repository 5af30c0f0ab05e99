#include "apps/bench/soak.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/filter/pose_filter.h"

namespace edge_mcl {

double residentMegabytes() {
  // Second number of statm: resident pages (proc(5)).
  std::ifstream in("/proc/self/statm");
  double total = 0, resident = 0;
  in >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

double peakResidentMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;
}

double soak(const LocalizationMap& map, const Sequence& sequence, size_t updates) {
  constexpr size_t kImages = 20;
  std::vector<cv::Mat> images;
  for (size_t i = 0; i < std::min(kImages, sequence.frames.size()); ++i)
    images.push_back(readImage(sequence.frames[i].image_file, sequence.camera));
  if (images.size() < 2) throw InputError("soak: the sequence has fewer than two images");
  PoseFilter filter(map.params().filter, map.params().refinement);
  filter.initialize(startOf(sequence), sequence.initial_std_position, sequence.initial_std_angle);
  const double dt = sequence.frames[1].time - sequence.frames[0].time;
  double early = 0;
  const size_t tenth = std::max<size_t>(1, updates / 10);
  for (size_t k = 0; k < updates; ++k) {
    const size_t phase = k % (2 * images.size() - 2);
    const size_t i = phase < images.size() ? phase : 2 * images.size() - 2 - phase;
    if (k > 0) filter.predictWithoutOdometry(dt);
    filter.update(map, {{map.prepare(sequence.camera, images[i], {}, "soak")}});
    if ((k + 1) % tenth != 0) continue;
    std::printf("  %zu updates: %.1f MB resident\n", k + 1, residentMegabytes());
    std::fflush(stdout);
    if (k + 1 == tenth) early = residentMegabytes();
  }
  return residentMegabytes() - early;
}

}  // namespace edge_mcl
