// Reads and writes distance fields.
#include <optional>
#include <utility>

#include "edge_mcl/core/base/stored_data.h"
#include "edge_mcl/core/depth/distance_field.h"

namespace edge_mcl {

namespace {

constexpr StoredKind kKind{"emcldf03", "a distance field"};

struct Info {
  double origin[3], voxel_size, truncation;
  int32_t bricks[3], unused;
};

}  // namespace

uint64_t DistanceField::hashOf(const MeshModel& mesh, const Options& options) {
  ContentHash hash;
  hash.add(reinterpret_cast<const uint32_t*>(kKind.magic), 2);
  hash.add(&options.truncation, 1);
  hash.add(&options.voxel_size, 1);
  hash.add(&options.most_bytes, 1);
  hash.add(mesh.vertices.data(), mesh.vertices.size());
  hash.add(mesh.triangles.data(), mesh.triangles.size());
  return hash.value();
}

void DistanceField::write(const std::string& file, uint64_t hash) const {
  Info info{};
  for (int k = 0; k < 3; ++k) {
    info.origin[k] = origin_[k];
    info.bricks[k] = bricks_[k];
  }
  info.voxel_size = voxel_size_;
  info.truncation = truncation_;
  writeStored(file, kKind, hash,
              {{&info, sizeof info},
               {brick_of_.data(), 4 * brick_of_.size()},
               {voxels_.data(), 4 * voxels_.size()}});
}

DistanceField DistanceField::read(const std::string& file, uint64_t hash) {
  StoredReader reader(file, kKind, hash, 3);
  if (reader.count<Info>(0) != 1) throw InputError(file + ": damaged");
  Info info{};
  reader.read(&info);
  DistanceField field;
  for (int k = 0; k < 3; ++k) {
    field.origin_[k] = info.origin[k];
    field.bricks_[k] = info.bricks[k];
  }
  field.voxel_size_ = info.voxel_size;
  field.truncation_ = info.truncation;
  field.brick_of_.resize(reader.count<int32_t>(1));
  field.voxels_.resize(reader.count<uint32_t>(2));
  reader.read(field.brick_of_.data());
  reader.read(field.voxels_.data());
  reader.finish();
  return field;
}

DistanceField storedDistanceField(const MeshModel& mesh, const DistanceField::Options& options,
                                  const std::string& model_file, std::string* warning) {
  const uint64_t hash = DistanceField::hashOf(mesh, options);
  const std::vector<std::string> files = storagePlaces(model_file, hash, "field");
  std::optional<DistanceField> stored;
  if (readFromOne(files,
                  [&](const std::string& file) { stored = DistanceField::read(file, hash); }))
    return std::move(*stored);
  DistanceField field(mesh, options);
  const std::string why =
      writeToOne(files, [&](const std::string& file) { field.write(file, hash); });
  if (!why.empty())
    *warning = "the distance field cannot be stored and is computed at every start: " + why;
  return field;
}

}  // namespace edge_mcl
