#include "edge_mcl/core/import/raw_model.h"

#include <sys/stat.h>

#include <algorithm>

namespace edge_mcl {

namespace {

/// Marks the beginning and the end of the data.
constexpr uint64_t kMark = 0x65646765206d6f64;

struct Writer {
  std::FILE* file;
  bool good = true;

  void bytes(const void* data, size_t size) {
    good = good && (size == 0 || std::fwrite(data, 1, size, file) == size);
  }
  template <class T>
  void number(const T& value) {
    bytes(&value, sizeof(T));
  }
  template <class T>
  void list(const std::vector<T>& values) {
    number<uint64_t>(values.size());
    bytes(values.data(), values.size() * sizeof(T));
  }
  void text(const std::string& value) {
    number<uint64_t>(value.size());
    bytes(value.data(), value.size());
  }
};

struct Reader {
  std::FILE* file;
  uint64_t most = 0;  ///< bytes of the file, which no list can exceed
  bool good = true;

  void bytes(void* data, size_t size) {
    good = good && (size == 0 || std::fread(data, 1, size, file) == size);
  }
  template <class T>
  void number(T* value) {
    bytes(value, sizeof(T));
  }
  /// @return number of elements, 0 when it cannot be right.
  uint64_t count(size_t size_of_one) {
    uint64_t n = 0;
    number(&n);
    good = good && n <= most / size_of_one;
    return good ? n : 0;
  }
  template <class T>
  void list(std::vector<T>* values) {
    values->resize(count(sizeof(T)));
    bytes(values->data(), values->size() * sizeof(T));
  }
  void text(std::string* value) {
    value->resize(count(1));
    bytes(value->data(), value->size());
  }
};

bool isConsistent(const RawModel& m) {
  const auto below = [](const auto& lists, size_t limit) {
    return std::all_of(lists.begin(), lists.end(), [&](const auto& list) {
      return std::all_of(list.begin(), list.end(), [&](uint32_t i) { return i < limit; });
    });
  };
  const auto each = [](const std::vector<uint32_t>& numbers, size_t limit) {
    return std::all_of(numbers.begin(), numbers.end(), [&](uint32_t i) { return i < limit; });
  };
  return m.rounding.size() == m.vertices.size() &&
         m.triangle_material.size() == m.triangles.size() &&
         m.triangle_object.size() == m.triangles.size() && m.line_object.size() == m.lines.size() &&
         below(m.triangles, m.vertices.size()) && below(m.lines, m.vertices.size()) &&
         each(m.triangle_material, m.material_colors.size()) &&
         each(m.triangle_object, m.objects.size()) && each(m.line_object, m.objects.size());
}

}  // namespace

bool writeRawModel(const RawModel& m, std::FILE* file) {
  Writer w{file};
  w.number(kMark);
  w.list(m.vertices);
  w.list(m.triangles);
  w.list(m.triangle_material);
  w.list(m.triangle_object);
  w.list(m.lines);
  w.list(m.line_object);
  w.list(m.material_colors);
  w.number<uint64_t>(m.objects.size());
  for (const std::string& name : m.objects) w.text(name);
  w.number(m.unit);
  w.text(m.unit_name);
  w.number(m.up_axis);
  w.number(m.in_metres);
  w.list(m.rounding);
  w.number(m.empty_faces);
  w.number(kMark);
  return w.good && std::fflush(file) == 0;
}

bool readRawModel(std::FILE* file, RawModel* m) {
  struct stat info {};
  if (fstat(fileno(file), &info) != 0) return false;
  Reader r{file, static_cast<uint64_t>(std::max<off_t>(0, info.st_size))};
  uint64_t mark = 0;
  r.number(&mark);
  if (!r.good || mark != kMark) return false;
  r.list(&m->vertices);
  r.list(&m->triangles);
  r.list(&m->triangle_material);
  r.list(&m->triangle_object);
  r.list(&m->lines);
  r.list(&m->line_object);
  r.list(&m->material_colors);
  m->objects.resize(r.count(sizeof(uint64_t)));
  for (std::string& name : m->objects) r.text(&name);
  r.number(&m->unit);
  r.text(&m->unit_name);
  r.number(&m->up_axis);
  r.number(&m->in_metres);
  r.list(&m->rounding);
  r.number(&m->empty_faces);
  r.number(&mark);
  return r.good && mark == kMark && isConsistent(*m);
}

}  // namespace edge_mcl
