#include "edge_mcl/core/places/prepared_places.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/places/search_places.h"

namespace edge_mcl {

namespace {

constexpr size_t kBytesOfPlace = 3 * raster::kAround * sizeof(uint64_t);
/// Distance from a place to the camera positions for which it stands, in units of the spacing: the
/// mean over a cube.
constexpr double kMeanDistance = 0.48;
/// Error of the rotation that the lines of an image give.
constexpr double kRotationError = 1 * kDegree;
/// Lines that are nearer would fill the raster.
constexpr int kMostRows = 6;

/// Marks a part of a line along `axis`. @param from, to its ends, relative to the place, in the
/// axes of the building. @param reach distance that the place may be off, m.
void mark(const Eigen::Vector3d& from, const Eigen::Vector3d& to, int axis, double reach,
          uint64_t* rows) {
  const Eigen::Vector3d middle = (from + to) / 2;
  const double across = std::hypot(middle[(axis + 1) % 3], middle[(axis + 2) % 3]);
  if (across < 1e-3) return;
  const double error = std::atan2(reach, across) + kRotationError;
  const int most = std::min(kMostRows, static_cast<int>(std::lround(error / raster::kRow)));
  const double along = std::atan2(reach, middle.norm()) + kRotationError;
  const double a = raster::alongOf(from, axis), b = raster::alongOf(to, axis);
  const uint64_t bits = raster::bitsOf(std::min(a, b) - along, std::max(a, b) + along);
  const int row = raster::rowOf(middle, axis);
  for (int offset = -most; offset <= most; ++offset)
    rows[(row + offset + raster::kAround) % raster::kAround] |= bits;
}

}  // namespace

PreparedPlaces::PreparedPlaces(const FreeSpace& space, const Visibility& visibility,
                               const SearchParameters& p, const BuildingAxes& axes,
                               const Progress& progress)
    : axes_(axes) {
  const double most =
      std::max(1.0, 1e6 * p.prepared_megabytes / static_cast<double>(kBytesOfPlace));
  // The volume tells the spacing to some per cent.
  constexpr double kWider = 1.02;
  spacing_ = std::max(p.prepared_spacing, std::cbrt(space.volume() / most));
  std::vector<Eigen::Vector3d> positions = space.places(spacing_);
  for (; static_cast<double>(positions.size()) > most; positions = space.places(spacing_))
    spacing_ *= kWider * std::cbrt(static_cast<double>(positions.size()) / most);
  for (const Eigen::Vector3d& position : positions) positions_.push_back(position.cast<float>());
  if (positions_.empty())
    throw InputError(
        "search: no place in the model is at least search.clearance away from all surfaces");
  bits_.assign(positions_.size() * 3 * raster::kAround, 0);
  std::atomic<size_t> done{0};
  tbb::parallel_for(size_t{0}, positions_.size(), [&](size_t place) {
    addPlace(visibility, place);
    const size_t count = ++done;
    if (progress && count % 256 == 0)
      progress(static_cast<double>(count) / static_cast<double>(positions_.size()));
  });
}

void PreparedPlaces::addPlace(const Visibility& visibility, size_t place) {
  const EdgeModel& model = visibility.model();
  const uint32_t thinning = SearchPlaces::thinningFor(model);
  const Eigen::Vector3d eye = positions_[place].cast<double>();
  const VisibleSet visible = visibility.exact(eye, thinning);
  const double half = 0.5 * model.sample_step * thinning;
  const double reach = kMeanDistance * spacing_;
  for (const VisibleSet::Segment& s : visible.segments) {
    const EdgeSegment& segment = visible.edgeSegment(s);
    const EdgeLine& line = model.lines[segment.line];
    const Eigen::Vector3d tangent =
        axes_.R_map_building.transpose() * line.tangent().cast<double>();
    int axis = 0;
    if (tangent.cwiseAbs().maxCoeff(&axis) < std::cos(kAlongAxis)) continue;
    // Neighbouring samples are marked apart: their rows may differ, and a sample costs little.
    const double whole = static_cast<double>(line.length()) / 2;
    for (uint32_t i = 0; i < segment.sample_count; ++i) {
      if ((s.samples >> i & 1) == 0) continue;
      const Eigen::Vector3d at =
          axes_.R_map_building.transpose() * (model.samplePosition(segment, i) - eye);
      const Eigen::Vector3d step = std::min(half, whole) * tangent;
      mark(at - step, at + step, axis, reach,
           &bits_[(place * 3 + static_cast<size_t>(axis)) * raster::kAround]);
    }
  }
}

}  // namespace edge_mcl
