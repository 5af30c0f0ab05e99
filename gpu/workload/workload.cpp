#include "edge_mcl/gpu/workload/workload.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <type_traits>

namespace edge_mcl::gpu {

namespace {

constexpr char kMagic[16] = "edge_mcl work 4";
constexpr uint64_t kMostElements = uint64_t{1} << 32;

/// Calls `part` for every part of the file, in the order of the file.
template <class W, class F>
void visitParts(W& w, F&& part) {
  part.text(w.name);
  part.value(w.camera);
  part.value(w.table);
  part.value(w.rule);
  part.value(w.combination);
  part.array(w.pairs);
  part.value(w.recipe.work);
  part.array(w.recipe.directions);
  part.array(w.recipe.shifts);
  part.array(w.recipe.level_codes);
  part.array(w.recipe.level_borders);
  part.array(w.grey);
  part.array(w.ignore);
  part.array(w.chunks);
  part.array(w.samples);
  part.array(w.cells);
  part.array(w.particles);
  part.array(w.reference);
  part.value(w.plain_ms);
  part.value(w.cpu_ms);
}

struct Writer {
  std::ofstream out;
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    out.write(reinterpret_cast<const char*>(&v), sizeof v);
  }
  template <class V>
  void array(const V& v) {
    value(static_cast<uint64_t>(v.size()));
    out.write(reinterpret_cast<const char*>(v.data()),
              static_cast<std::streamsize>(v.size() * sizeof v[0]));
  }
  void text(const std::string& s) { array(s); }
};

struct Reader {
  std::ifstream in;
  std::string file;
  uint64_t left = 0;  // bytes of the file that are not read yet
  void bytes(void* to, uint64_t size) {
    if (size > left) throw std::runtime_error(file + ": the workload is cut off");
    in.read(static_cast<char*>(to), static_cast<std::streamsize>(size));
    if (!in) throw std::runtime_error(file + ": cannot be read");
    left -= size;
  }
  template <class T>
  void value(T& v) {
    bytes(&v, sizeof v);
  }
  template <class V>
  void array(V& v) {
    uint64_t size = 0;
    value(size);
    if (size > kMostElements || size * sizeof v[0] > left)
      throw std::runtime_error(file + ": the workload is cut off");
    v.resize(size);
    if (size > 0) bytes(&v[0], size * sizeof v[0]);
  }
  void text(std::string& s) { array(s); }
};

/// Whether kernels that use the recipe stay within its arrays.
bool isSound(const Workload& w) {
  const TableRecipe& r = w.recipe;
  const PictureWork& p = r.work;
  if (p.width != w.table.width || p.height != w.table.height || p.bins != w.table.bins ||
      p.bins > kMostBins || p.levels < 1 || p.entries < 1 || p.blur_radius < 0 ||
      p.blur_radius > kMostBlurRadius || p.window_cells < 1)
    return false;
  if (p.cell_columns != (p.width + kClutterCell - 1) / kClutterCell ||
      p.cell_rows != (p.height + kClutterCell - 1) / kClutterCell ||
      p.longest != std::max(p.width, p.height))
    return false;
  if (p.tile < 0 || (p.tile > 0 && (p.tile_columns != (p.width + p.tile - 1) / p.tile ||
                                    p.tile_rows != (p.height + p.tile - 1) / p.tile)))
    return false;
  const auto bins = static_cast<size_t>(p.bins);
  for (const DirectionBin& d : r.directions)
    if (d.no_edge < 1 || d.no_edge >= p.entries) return false;
  return r.directions.size() == bins && r.shifts.size() == bins * p.longest &&
         r.level_codes.size() == bins * p.levels * p.entries &&
         r.level_borders.size() + 1 == static_cast<size_t>(p.levels) &&
         w.grey.size() == pixelsOf(p) && (w.ignore.empty() || w.ignore.size() == pixelsOf(p));
}

void check(const Workload& w, const std::string& file) {
  const auto require = [&](bool good, const char* what) {
    if (!good) throw std::runtime_error(file + ": the workload is damaged: " + what);
  };
  const Table& t = w.table;
  require(t.width > 0 && t.height > 0 && t.bins > 0 && t.bins < 256 && t.width <= 20000 &&
              t.height <= 20000,
          "table size");
  require(w.pairs.size() == (static_cast<size_t>(t.width) + 1) * (t.height + 1) * t.bins + 1,
          "table");
  require(w.camera.last_x == static_cast<float>(t.width - 1) &&
              w.camera.last_y == static_cast<float>(t.height - 1),
          "image size");
  require(w.recipe.work.bins == 0 || isSound(w), "recipe of the table");
  require(w.samples.size() == w.chunks.size() * kLanes, "samples");
  for (const Chunk& c : w.chunks) require(c.count <= kLanes, "chunks");
  for (const Cell& c : w.cells) {
    require(c.first_chunk <= w.chunks.size() && c.chunk_count <= w.chunks.size() - c.first_chunk,
            "cells");
    uint32_t end = 0;
    for (const uint32_t of_part : c.part_end) {
      require(of_part >= end, "order of parts");
      end = of_part;
    }
    require(end == c.chunk_count, "parts");
  }
  for (const Particle& p : w.particles) require(p.cell < w.cells.size(), "cell of a particle");
  require(w.reference.size() == w.particles.size(), "reference");
}

}  // namespace

void writeWorkload(const Workload& workload, const std::string& file) {
  Writer writer{std::ofstream(file, std::ios::binary)};
  writer.out.write(kMagic, sizeof kMagic);
  visitParts(workload, writer);
  writer.out.flush();
  if (!writer.out) throw std::runtime_error(file + ": cannot be written");
}

Workload readWorkload(const std::string& file) {
  Reader reader{std::ifstream(file, std::ios::binary | std::ios::ate), file};
  if (!reader.in) throw std::runtime_error(file + ": cannot be read");
  reader.left = static_cast<uint64_t>(reader.in.tellg());
  reader.in.seekg(0);
  char magic[sizeof kMagic] = {};
  reader.bytes(magic, sizeof magic);
  if (std::memcmp(magic, kMagic, sizeof kMagic) != 0)
    throw std::runtime_error(file + ": not a workload of this version");
  Workload workload;
  visitParts(workload, reader);
  check(workload, file);
  return workload;
}

}  // namespace edge_mcl::gpu
