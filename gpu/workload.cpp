#include "workload.h"

#include <cstring>
#include <fstream>
#include <stdexcept>
#include <type_traits>

namespace edge_mcl::gpu {

namespace {

constexpr char kMagic[16] = "edge_mcl work 2";
constexpr uint64_t kMostElements = uint64_t{1} << 32;

/// Visits the parts of the file in their order.
template <class W, class F>
void visitParts(W& w, F&& part) {
  part.text(w.name);
  part.value(w.camera);
  part.value(w.table);
  part.value(w.rule);
  part.value(w.combination);
  part.array(w.pairs);
  part.array(w.along);
  part.array(w.segments);
  part.array(w.group_ends);
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
  uint64_t left = 0;  // bytes of the file
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

void check(const Workload& w, const std::string& file) {
  const auto require = [&](bool good, const char* what) {
    if (!good) throw std::runtime_error(file + ": the workload is damaged: " + what);
  };
  const Table& t = w.table;
  require(t.stride > 1 && t.rows > 1 && t.bins > 0 && t.bins < 256 && t.stride < 20002 &&
              t.rows < 20002,
          "table size");
  require(w.pairs.size() >= static_cast<size_t>(t.stride) * t.rows * t.bins + 1, "table");
  require(w.camera.last_x == static_cast<float>(t.stride - 2) &&
              w.camera.last_y == static_cast<float>(t.rows - 2),
          "image size");
  for (const Cell& c : w.cells) {
    require(c.first_group <= w.group_ends.size() &&
                c.group_count <= w.group_ends.size() - c.first_group,
            "groups");
    uint32_t end = 0;
    for (uint32_t g = 0; g < c.group_count; ++g) {
      require(w.group_ends[c.first_group + g] >= end, "order of groups");
      end = w.group_ends[c.first_group + g];
    }
    require(c.first_segment <= w.segments.size() && end <= w.segments.size() - c.first_segment,
            "segments");
  }
  for (const Segment& s : w.segments)
    for (uint32_t i = 0; i < kTeamLanes; ++i)
      require(!(s.seen >> i & 1u) || (s.first < w.along.size() && i < w.along.size() - s.first),
              "samples");
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
