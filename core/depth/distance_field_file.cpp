// Reads and writes distance fields.
#include <unistd.h>

#include <cinttypes>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/depth/distance_field.h"

namespace edge_mcl {

namespace fs = std::filesystem;

namespace {

constexpr char kMagic[8] = {'e', 'm', 'c', 'l', 'd', 'f', '0', '2'};

/// FNV-1a hash over 32-bit words.
class Hash {
 public:
  template <class T>
  void add(const T* data, size_t count) {
    static_assert(sizeof(T) % 4 == 0);
    for (size_t i = 0; i < count * sizeof(T) / 4; ++i) {
      uint32_t word = 0;
      std::memcpy(&word, reinterpret_cast<const char*>(data) + 4 * i, 4);
      value_ = (value_ ^ word) * 1099511628211ull;
    }
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 14695981039346656037ull;
};

/// Start of a file. The numbers of the bricks and the voxels follow.
struct Header {
  char magic[8];
  uint64_t hash, checksum, brick_count, voxel_count;
  double origin[3], voxel_size, truncation;
  int32_t bricks[3], unused;
};

/// Checksum of the whole file without the checksum itself.
uint64_t checksumOf(Header header, const std::vector<int32_t>& bricks,
                    const std::vector<uint32_t>& voxels) {
  Hash hash;
  header.checksum = 0;
  hash.add(&header, 1);
  hash.add(bricks.data(), bricks.size());
  hash.add(voxels.data(), voxels.size());
  return hash.value();
}

}  // namespace

uint64_t DistanceField::hashOf(const MeshModel& mesh, const Options& options) {
  Hash hash;
  hash.add(reinterpret_cast<const uint32_t*>(kMagic), 2);
  hash.add(&options.truncation, 1);
  hash.add(&options.voxel_size, 1);
  hash.add(&options.most_bytes, 1);
  hash.add(mesh.vertices.data(), mesh.vertices.size());
  hash.add(mesh.triangles.data(), mesh.triangles.size());
  return hash.value();
}

void DistanceField::write(const std::string& file, uint64_t hash) const {
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.hash = hash;
  header.brick_count = brick_of_.size();
  header.voxel_count = voxels_.size();
  for (int k = 0; k < 3; ++k) {
    header.origin[k] = origin_[k];
    header.bricks[k] = bricks_[k];
  }
  header.voxel_size = voxel_size_;
  header.truncation = truncation_;
  header.checksum = checksumOf(header, brick_of_, voxels_);
  // The file gets its name when it is complete, because another process may read or write the same
  // field.
  const std::string part = file + "." + std::to_string(getpid());
  std::ofstream out(part, std::ios::binary);
  out.write(reinterpret_cast<const char*>(&header), sizeof header);
  out.write(reinterpret_cast<const char*>(brick_of_.data()),
            static_cast<std::streamsize>(4 * brick_of_.size()));
  out.write(reinterpret_cast<const char*>(voxels_.data()),
            static_cast<std::streamsize>(4 * voxels_.size()));
  out.close();
  std::error_code failed;
  if (out) fs::rename(part, file, failed);
  if (!out || failed) {
    fs::remove(part, failed);
    throw InputError(file + ": cannot be written");
  }
}

DistanceField DistanceField::read(const std::string& file, uint64_t hash) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file + ": missing or not readable");
  Header h{};
  in.read(reinterpret_cast<char*>(&h), sizeof h);
  if (!in || std::memcmp(h.magic, kMagic, sizeof kMagic) != 0)
    throw InputError(file + ": not a distance field");
  if (h.hash != hash) throw InputError(file + ": made from another model or with other options");
  std::error_code failed;
  const uintmax_t bytes = fs::file_size(file, failed);
  // The sizes are checked first, so that a broken header cannot ask for all memory.
  if (failed || h.brick_count > bytes || h.voxel_count > bytes ||
      bytes != sizeof h + 4 * (h.brick_count + h.voxel_count))
    throw InputError(file + ": truncated");
  DistanceField field;
  for (int k = 0; k < 3; ++k) {
    field.origin_[k] = h.origin[k];
    field.bricks_[k] = h.bricks[k];
  }
  field.voxel_size_ = h.voxel_size;
  field.truncation_ = h.truncation;
  field.brick_of_.resize(h.brick_count);
  field.voxels_.resize(h.voxel_count);
  in.read(reinterpret_cast<char*>(field.brick_of_.data()),
          static_cast<std::streamsize>(4 * h.brick_count));
  in.read(reinterpret_cast<char*>(field.voxels_.data()),
          static_cast<std::streamsize>(4 * h.voxel_count));
  if (!in || checksumOf(h, field.brick_of_, field.voxels_) != h.checksum)
    throw InputError(file + ": damaged");
  return field;
}

DistanceField storedDistanceField(const MeshModel& mesh, const DistanceField::Options& options,
                                  const std::string& model_file, std::string* warning) {
  const uint64_t hash = DistanceField::hashOf(mesh, options);
  char name[32];
  std::snprintf(name, sizeof name, "%016" PRIx64 ".field", hash);
  std::vector<std::string> places{model_file + "." + name};
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (cache && *cache)
    places.push_back((fs::path(cache) / "edge_mcl" / name).string());
  else if (home && *home)
    places.push_back((fs::path(home) / ".cache" / "edge_mcl" / name).string());
  for (const std::string& place : places) {
    try {
      return DistanceField::read(place, hash);
    } catch (const InputError&) {
      continue;  // the next place, or a new field
    }
  }
  DistanceField field(mesh, options);
  std::string why;
  for (const std::string& place : places) {
    try {
      std::error_code ignored;
      fs::create_directories(fs::path(place).parent_path(), ignored);
      field.write(place, hash);
      return field;
    } catch (const InputError& e) {
      why = e.what();
    }
  }
  *warning = "the distance field cannot be stored and is computed at every start: " + why;
  return field;
}

}  // namespace edge_mcl
