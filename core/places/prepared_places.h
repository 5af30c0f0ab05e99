/// What places all over a building see, prepared once so that an image is compared with all of them
/// in a fraction of a second.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/places/building_axes.h"
#include "edge_mcl/core/places/free_space.h"
#include "edge_mcl/core/places/sphere_raster.h"

namespace edge_mcl {

/// The model lines along the axes of the building that each place sees, as rows of bits. A line is
/// wider where it is near, since its direction changes more between two places. The idea that lines
/// of known direction need only two numbers per place is that of J. Kim et al., "Fully Geometric
/// Panoramic Localization", CVPR 2024; their distance functions are rows of bits here.
class PreparedPlaces {
 public:
  /// Called with a share from 0 to 1, from any thread.
  using Progress = std::function<void(double)>;

  /// Finds by rays what each place sees. This takes about 12 s of two cores for a building of 1,000
  /// square metres.
  /// @throws InputError when the free space holds no place.
  PreparedPlaces(const FreeSpace& space, const Visibility& visibility,
                 const SearchParameters& params, const BuildingAxes& axes,
                 const Progress& progress = {});

  /// Hash of everything that determines the places: mesh, edges, options and method.
  /// @param occlusion_tolerance see Visibility, m
  static uint64_t hashOf(const MeshModel& mesh, const EdgeModel& model,
                         const SearchParameters& params, double occlusion_tolerance);
  /// Writes the places to a file. @throws InputError when it cannot be written.
  void write(const std::string& file, uint64_t hash) const;
  /// Reads places. @throws InputError when the file is missing or broken, or has another hash.
  static PreparedPlaces read(const std::string& file, uint64_t hash);

  const BuildingAxes& axes() const { return axes_; }
  /// Distance between neighbouring places, m.
  double spacing() const { return spacing_; }
  size_t count() const { return positions_.size(); }
  const Eigen::Vector3f& position(size_t place) const { return positions_[place]; }
  /// Rows of one axis: raster::kAround words.
  const uint64_t* rows(size_t place, int axis) const {
    return &bits_[(place * 3 + static_cast<size_t>(axis)) * raster::kAround];
  }
  size_t bytes() const { return bits_.size() * sizeof(uint64_t); }

 private:
  PreparedPlaces() = default;
  void addPlace(const Visibility& visibility, size_t place);

  BuildingAxes axes_;
  double spacing_ = 0;
  std::vector<Eigen::Vector3f> positions_;  // map frame
  std::vector<uint64_t> bits_;
};

/// Returns the places of a model file. It reads stored places if there are some. Otherwise it makes
/// them with `make` and stores them. Where they cannot be stored, the next start makes them again.
PreparedPlaces storedPreparedPlaces(const std::string& model_file, uint64_t hash,
                                    const std::function<PreparedPlaces()>& make);

}  // namespace edge_mcl
