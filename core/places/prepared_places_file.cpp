// Reads and writes prepared places.
#include <algorithm>
#include <optional>
#include <utility>

#include "edge_mcl/core/base/stored_data.h"
#include "edge_mcl/core/places/prepared_places.h"

namespace edge_mcl {

namespace {

constexpr StoredKind kKind{"emclpp01", "a file of prepared places"};

struct Info {
  double R_map_building[9], share, spacing;
};

}  // namespace

uint64_t PreparedPlaces::hashOf(const MeshModel& mesh, const EdgeModel& model,
                                const SearchParameters& params, double occlusion_tolerance) {
  ContentHash hash;
  hash.add(reinterpret_cast<const uint32_t*>(kKind.magic), 2);
  const double options[] = {params.prepared_spacing, params.prepared_megabytes,
                            params.clearance,        params.enclosure,
                            model.sample_step,       occlusion_tolerance};
  hash.add(options, std::size(options));
  hash.add(mesh.vertices.data(), mesh.vertices.size());
  hash.add(mesh.triangles.data(), mesh.triangles.size());
  // Lines beside hiding faces are seen through more of them.
  const auto hiding =
      static_cast<uint64_t>(std::count(mesh.hides_only.begin(), mesh.hides_only.end(), true));
  hash.add(&hiding, 1);
  for (const EdgeLine& line : model.lines) {
    hash.add(line.start.data(), 3);
    hash.add(line.end.data(), 3);
  }
  return hash.value();
}

void PreparedPlaces::write(const std::string& file, uint64_t hash) const {
  Info info{};
  Eigen::Map<Eigen::Matrix3d>(info.R_map_building) = axes_.R_map_building;
  info.share = axes_.share;
  info.spacing = spacing_;
  writeStored(file, kKind, hash,
              {{&info, sizeof info},
               {positions_.data(), positions_.size() * sizeof(Eigen::Vector3f)},
               {bits_.data(), bytes()}});
}

PreparedPlaces PreparedPlaces::read(const std::string& file, uint64_t hash) {
  StoredReader reader(file, kKind, hash, 3);
  const size_t count = reader.count<Eigen::Vector3f>(1);
  if (reader.count<Info>(0) != 1 ||
      reader.count<uint64_t>(2) != count * 3 * static_cast<size_t>(raster::kAround))
    throw InputError(file + ": damaged");
  Info info{};
  reader.read(&info);
  PreparedPlaces places;
  places.axes_.R_map_building = Eigen::Map<Eigen::Matrix3d>(info.R_map_building);
  places.axes_.share = info.share;
  places.spacing_ = info.spacing;
  places.positions_.resize(count);
  places.bits_.resize(reader.count<uint64_t>(2));
  reader.read(places.positions_.data());
  reader.read(places.bits_.data());
  reader.finish();
  return places;
}

PreparedPlaces storedPreparedPlaces(const std::string& model_file, uint64_t hash,
                                    const std::function<PreparedPlaces()>& make) {
  const std::vector<std::string> files = storagePlaces(model_file, hash, "places");
  std::optional<PreparedPlaces> stored;
  if (readFromOne(files,
                  [&](const std::string& file) { stored = PreparedPlaces::read(file, hash); }))
    return std::move(*stored);
  PreparedPlaces places = make();
  writeToOne(files, [&](const std::string& file) { places.write(file, hash); });
  return places;
}

}  // namespace edge_mcl
