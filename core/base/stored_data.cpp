#include "edge_mcl/core/base/stored_data.h"

#include <unistd.h>

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace edge_mcl {

namespace fs = std::filesystem;

namespace {

/// Start of a file. The sizes of the parts and the parts follow.
struct Header {
  char magic[8];
  uint64_t hash, checksum, parts;
};

}  // namespace

void writeStored(const std::string& file, const StoredKind& kind, uint64_t hash,
                 const std::vector<StoredPart>& parts) {
  Header header{};
  std::memcpy(header.magic, kind.magic, sizeof header.magic);
  header.hash = hash;
  header.parts = parts.size();
  std::vector<uint64_t> sizes;
  sizes.reserve(parts.size());
  for (const StoredPart& part : parts) sizes.push_back(part.bytes);
  ContentHash checksum;
  checksum.add(sizes.data(), sizes.size());
  for (const StoredPart& part : parts)
    checksum.add(static_cast<const uint32_t*>(part.data), part.bytes / 4);
  header.checksum = checksum.value();
  const std::string unfinished = file + "." + std::to_string(getpid());
  std::ofstream out(unfinished, std::ios::binary);
  const auto write = [&](const void* data, size_t bytes) {
    out.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  };
  write(&header, sizeof header);
  write(sizes.data(), 8 * sizes.size());
  for (const StoredPart& part : parts) write(part.data, part.bytes);
  out.close();
  std::error_code failed;
  if (out) fs::rename(unfinished, file, failed);
  if (!out || failed) {
    fs::remove(unfinished, failed);
    throw InputError(file + ": cannot be written");
  }
}

StoredReader::StoredReader(const std::string& file, const StoredKind& kind, uint64_t hash,
                           size_t parts)
    : file_(file), sizes_(parts) {
  std::error_code unknown;
  // A pipe of this name would never answer.
  if (fs::is_regular_file(file, unknown)) in_.open(file, std::ios::binary);
  if (!in_.is_open()) throw InputError(file + ": missing or not readable");
  Header header{};
  in_.read(reinterpret_cast<char*>(&header), sizeof header);
  if (!in_ || std::memcmp(header.magic, kind.magic, sizeof header.magic) != 0)
    throw InputError(file + ": not " + kind.name);
  if (header.hash != hash)
    throw InputError(file + ": made from another model or with other options");
  in_.read(reinterpret_cast<char*>(sizes_.data()), static_cast<std::streamsize>(8 * parts));
  std::error_code failed;
  const uintmax_t bytes = fs::file_size(file, failed);
  uint64_t expected = sizeof header + 8 * parts;
  // The sizes are checked first, so that a broken file cannot ask for all memory.
  const bool is_sane = in_ && !failed && header.parts == parts &&
                       std::all_of(sizes_.begin(), sizes_.end(), [&](uint64_t size) {
                         expected += size;
                         return size <= bytes && size % 4 == 0;
                       });
  if (!is_sane || bytes != expected) throw InputError(file + ": truncated");
  checksum_ = header.checksum;
  hash_.add(sizes_.data(), sizes_.size());
}

void StoredReader::readBytes(void* data) {
  const uint64_t size = sizes_[next_++];
  in_.read(static_cast<char*>(data), static_cast<std::streamsize>(size));
  if (in_) hash_.add(static_cast<const uint32_t*>(data), size / 4);
}

void StoredReader::finish() {
  if (!in_ || hash_.value() != checksum_) throw InputError(file_ + ": damaged");
}

std::vector<std::string> storagePlaces(const std::string& model_file, uint64_t hash,
                                       const char* extension) {
  char number[24];
  std::snprintf(number, sizeof number, "%016" PRIx64 ".", hash);
  const std::string name = std::string(number) + extension;
  std::vector<std::string> places{model_file + "." + name};
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (cache && *cache)
    places.push_back((fs::path(cache) / "edge_mcl" / name).string());
  else if (home && *home)
    places.push_back((fs::path(home) / ".cache" / "edge_mcl" / name).string());
  return places;
}

bool readFromOne(const std::vector<std::string>& files,
                 const std::function<void(const std::string&)>& read) {
  return std::any_of(files.begin(), files.end(), [&](const std::string& file) {
    try {
      read(file);
      return true;
    } catch (const InputError&) {
      return false;  // the next file, or new data
    }
  });
}

std::string writeToOne(const std::vector<std::string>& files,
                       const std::function<void(const std::string&)>& write) {
  std::string why;
  for (const std::string& file : files) {
    try {
      std::error_code ignored;
      fs::create_directories(fs::path(file).parent_path(), ignored);
      write(file);
      return "";
    } catch (const InputError& e) {
      why = e.what();
    }
  }
  return why;
}

}  // namespace edge_mcl
