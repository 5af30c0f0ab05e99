#include "edge_mcl/localization/lookup/place_lookup.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "edge_mcl/core/base/angles.h"

namespace edge_mcl {

namespace {

int countBits(uint64_t bits) { return __builtin_popcountll(bits); }

/// A segment of the image on the raster of its axis.
struct Arc {
  int row = 0;
  uint64_t bits = 0;
  double weight = 0;  ///< of each bit
};

/// An image in one orientation, as the raster of each axis shows it.
struct ImageRaster {
  Eigen::Matrix3d R_building_camera;
  std::array<std::vector<Arc>, 3> arcs;
  struct Field {
    int row = 0;
    uint64_t bits = 0;
  };
  std::array<std::vector<Field>, 3> view;  ///< rows that the image shows
  double view_bits = 0;
};

ImageRaster rasterOf(const std::vector<ImageLine>& lines, const Eigen::Matrix3d& R,
                     const CameraModel& camera, const cv::Mat& ignore) {
  constexpr double kParallel = 3 * kDegree;
  // A long segment is one line: beyond this its bits tell nothing more.
  constexpr double kIndependentBits = 6;
  ImageRaster image;
  image.R_building_camera = R;
  for (const ImageLine& line : lines) {
    const Eigen::Vector3d n = R * line.normal;
    int axis = 0;
    if (n.cwiseAbs().minCoeff(&axis) > std::sin(kParallel)) continue;
    const Eigen::Vector3d start = R * line.start, end = R * line.end;
    Arc arc;
    arc.row = raster::rowOf(start + end, axis);
    arc.bits = raster::bitsOf(raster::alongOf(start, axis), raster::alongOf(end, axis));
    const double count = countBits(arc.bits);
    arc.weight = std::min(count, kIndependentBits) / count;
    image.arcs[static_cast<size_t>(axis)].push_back(arc);
  }
  for (int axis = 0; axis < 3; ++axis)
    for (int row = 0; row < raster::kAround; ++row) {
      uint64_t bits = 0;
      for (int bit = 0; bit < raster::kAlong; ++bit) {
        Eigen::Vector2d pixel;
        if (!camera.project(R.transpose() * raster::directionAt(row, bit, axis), &pixel) ||
            !camera.contains(pixel))
          continue;
        if (!ignore.empty() && ignore.at<uint8_t>(static_cast<int>(std::lround(pixel.y())),
                                                  static_cast<int>(std::lround(pixel.x()))) != 0)
          continue;
        bits |= uint64_t{1} << bit;
      }
      if (bits == 0) continue;
      image.view[static_cast<size_t>(axis)].push_back({row, bits});
      image.view_bits += countBits(bits);
    }
  return image;
}

/// Log-ratio of the segments at a place against chance: a place that sees many lines explains every
/// image.
__attribute__((target_clones("avx2", "popcnt", "default"))) double scoreOf(
    const PreparedPlaces& places, size_t place, const ImageRaster& image) {
  constexpr double kExplained = 0.65;  // share of the segments along axes that the model has
  double score = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const uint64_t* rows = places.rows(place, static_cast<int>(axis));
    double filled = 0, all = 0;
    for (const ImageRaster::Field& field : image.view[axis]) {
      filled += countBits(rows[field.row] & field.bits);
      all += countBits(field.bits);
    }
    const double chance = std::clamp((filled + 1) / (all + 10), 0.01, 0.95);
    const double hit = std::log(std::max(kExplained, chance) / chance),
                 miss = std::log((1 - std::max(kExplained, chance)) / (1 - chance));
    for (const Arc& arc : image.arcs[axis]) {
      const int hits = countBits(rows[arc.row] & arc.bits);
      score += arc.weight * (hits * hit + (countBits(arc.bits) - hits) * miss);
    }
  }
  return score;
}

}  // namespace

std::vector<LookupPose> lookUp(const PreparedPlaces& places, const EdgeImage& image,
                               const CameraModel& camera, const KnownUp& up, size_t most,
                               const std::function<bool(const Eigen::Vector3d&)>& filter) {
  constexpr size_t kRotations = 3;
  const std::vector<ImageLine> lines = findImageLines(image, camera);
  return lookUp(places, lines, rotationsOfAxes(lines, up, kRotations), camera, image.ignore, most,
                filter);
}

std::vector<LookupPose> lookUp(const PreparedPlaces& places, const std::vector<ImageLine>& lines,
                               const std::vector<AxesRotation>& rotations,
                               const CameraModel& camera, const cv::Mat& ignore, size_t most,
                               const std::function<bool(const Eigen::Vector3d&)>& filter) {
  if (rotations.empty()) return {};
  std::vector<ImageRaster> images(4 * rotations.size());
  tbb::parallel_for(size_t{0}, images.size(), [&](size_t i) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(static_cast<double>(i % 4) * M_PI / 2, Eigen::Vector3d::UnitZ())
            .toRotationMatrix();
    images[i] = rasterOf(lines, turn * rotations[i / 4].R_building_camera, camera, ignore);
  });
  struct Candidate {
    double score = 0;
    uint32_t place = 0, image = 0;
  };
  constexpr size_t kOfPlace = 2;  // orientations
  std::vector<size_t> chosen;
  for (size_t place = 0; place < places.count(); ++place)
    if (!filter || filter(places.position(place).cast<double>())) chosen.push_back(place);
  std::vector<Candidate> found(chosen.size() * kOfPlace);
  tbb::parallel_for(size_t{0}, chosen.size(), [&](size_t k) {
    const size_t place = chosen[k];
    std::vector<Candidate> here;
    here.reserve(images.size());
    for (size_t i = 0; i < images.size(); ++i)
      here.push_back({scoreOf(places, place, images[i]), static_cast<uint32_t>(place),
                      static_cast<uint32_t>(i)});
    std::stable_sort(here.begin(), here.end(),
                     [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
    here.resize(kOfPlace, here.front());
    std::copy(here.begin(), here.end(), &found[k * kOfPlace]);
  });
  std::stable_sort(found.begin(), found.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  if (found.size() > most) found.resize(most);
  std::vector<LookupPose> poses;
  poses.reserve(found.size());
  for (const Candidate& c : found) {
    LookupPose pose;
    pose.score = c.score;
    pose.T_map_camera.linear() = places.axes().R_map_building * images[c.image].R_building_camera;
    pose.T_map_camera.translation() = places.position(c.place).cast<double>();
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace edge_mcl
