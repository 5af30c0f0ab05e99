#include "edge_mcl/core/import/file_facts.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

std::string textOf(const std::string& file, size_t most) {
  std::ifstream in(file, std::ios::binary);
  std::string text(most, '\0');
  in.read(text.data(), static_cast<std::streamsize>(most));
  text.resize(static_cast<size_t>(std::max<std::streamsize>(0, in.gcount())));
  return text;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// Schema of an IFC file in upper case, e.g. IFC2X3. Empty when the header does not name one.
std::string ifcSchema(const std::string& file) {
  constexpr size_t kHeader = 1 << 16;  // headers of programs have less than 4 kB
  const std::string text = textOf(file, kHeader);
  size_t at = upper(text).find("FILE_SCHEMA");
  if (at == std::string::npos) return "";
  at = text.find('\'', at);
  if (at == std::string::npos) return "";
  const size_t end = text.find('\'', at + 1);
  return end == std::string::npos ? "" : upper(text.substr(at + 1, end - at - 1));
}

/// Entities of a STEP file (ISO 10303-21) of some types: number -> type and arguments.
using Entities = std::map<unsigned long, std::pair<std::string, std::string>>;

Entities unitEntities(const std::string& file) {
  static constexpr std::array<const char*, 4> kTypes{
      "IFCUNITASSIGNMENT", "IFCSIUNIT", "IFCCONVERSIONBASEDUNIT", "IFCMEASUREWITHUNIT"};
  Entities found;
  std::ifstream in(file, std::ios::binary);
  std::string entity;
  // A mutated file may lack every semicolon. No entity of these types is longer than this.
  constexpr size_t kLongest = 4096;
  bool quoted = false, too_long = false;
  for (char c = 0; in.get(c);) {
    if (c == '\'') quoted = !quoted;
    if (c == ';' && !quoted) {
      const size_t equals = entity.find('=');
      const size_t hash = entity.find('#');
      if (!too_long && equals != std::string::npos && hash < equals) {
        const size_t open = entity.find('(', equals);
        std::string type = upper(entity.substr(equals + 1, open - equals - 1));
        type.erase(std::remove_if(type.begin(), type.end(),
                                  [](unsigned char x) { return std::isspace(x); }),
                   type.end());
        unsigned long number = 0;
        std::from_chars(entity.data() + hash + 1, entity.data() + equals, number);
        if (open != std::string::npos &&
            std::find(kTypes.begin(), kTypes.end(), type) != kTypes.end())
          found[number] = {type, entity.substr(open + 1)};
      }
      entity.clear();
      too_long = false;
    } else if (entity.size() < kLongest) {
      entity += c;
    } else {
      too_long = true;
    }
  }
  return found;
}

/// Numbers after '#' in a text.
std::vector<unsigned long> references(const std::string& text) {
  std::vector<unsigned long> list;
  for (size_t at = text.find('#'); at != std::string::npos; at = text.find('#', at + 1)) {
    unsigned long number = 0;
    std::from_chars(text.data() + at + 1, text.data() + text.size(), number);
    list.push_back(number);
  }
  return list;
}

/// Arguments of an entity, null when it has another type.
const std::string* argumentsOf(const Entities& entities, unsigned long number, const char* type) {
  const auto it = entities.find(number);
  return it != entities.end() && it->second.first == type ? &it->second.second : nullptr;
}

/// Unit of an IFCSIUNIT with these arguments: the metre with its prefix.
FileUnit siUnit(const std::string& arguments) {
  struct Prefix {
    const char *word, *name;
    double factor;
  };
  static constexpr std::array<Prefix, 6> kPrefixes{{{".MICRO.", "micrometre", 1e-6},
                                                    {".MILLI.", "millimetre", 1e-3},
                                                    {".CENTI.", "centimetre", 1e-2},
                                                    {".DECI.", "decimetre", 0.1},
                                                    {".HECTO.", "hectometre", 100},
                                                    {".KILO.", "kilometre", 1e3}}};
  const std::string upper_case = upper(arguments);
  for (const Prefix& p : kPrefixes)
    if (upper_case.find(p.word) != std::string::npos) return {p.factor, p.name, true};
  // assimp leaves this one out.
  if (upper_case.find(".DECA.") != std::string::npos) return {10, "decametre", false};
  return {1, "metre", true};
}

/// A conversion-based unit, e.g. of 0.3048 m. Its measure is IFCLENGTHMEASURE(0.3048),#12).
FileUnit convertedUnit(const std::string& unit, const Entities& entities) {
  FileUnit result;
  const size_t quote = unit.find('\'');
  if (quote != std::string::npos)
    result.name = unit.substr(quote + 1, unit.find('\'', quote + 1) - quote - 1);
  for (const unsigned long reference : references(unit)) {
    const std::string* measure = argumentsOf(entities, reference, "IFCMEASUREWITHUNIT");
    if (!measure) continue;
    const size_t open = measure->find('(');
    double value = 0;
    if (open != std::string::npos)
      std::from_chars(measure->data() + open + 1, measure->data() + measure->size(), value);
    for (const unsigned long base : references(*measure))
      if (const std::string* si = argumentsOf(entities, base, "IFCSIUNIT"))
        value *= siUnit(*si).metres;
    if (std::isfinite(value) && value > 0) result.metres = value;
  }
  return result;
}

FileUnit ifcUnit(const std::string& file) {
  const auto isLength = [](const std::string& arguments) {
    return upper(arguments).find(".LENGTHUNIT.") != std::string::npos;
  };
  const Entities entities = unitEntities(file);
  for (const auto& entry : entities) {
    if (entry.second.first != "IFCUNITASSIGNMENT") continue;
    for (const unsigned long number : references(entry.second.second)) {
      const std::string* si = argumentsOf(entities, number, "IFCSIUNIT");
      if (si && isLength(*si)) return siUnit(*si);
      const std::string* unit = argumentsOf(entities, number, "IFCCONVERSIONBASEDUNIT");
      if (unit && isLength(*unit)) return convertedUnit(*unit, entities);
    }
  }
  return {};
}

/// Unit of a DXF file: group code 70 after $INSUNITS (DXF reference, HEADER section).
FileUnit dxfUnit(const std::string& file) {
  // By number. Those of astronomy and of atoms have no length here, so that they are warned of.
  static const std::array<FileUnit, 25> kUnits{{{0, "", false},
                                                {0.0254, "inch", false},
                                                {0.3048, "foot", false},
                                                {1609.344, "mile", false},
                                                {1e-3, "millimetre", false},
                                                {1e-2, "centimetre", false},
                                                {1, "metre", false},
                                                {1e3, "kilometre", false},
                                                {2.54e-8, "microinch", false},
                                                {2.54e-5, "mil", false},
                                                {0.9144, "yard", false},
                                                {0, "angstrom", false},
                                                {0, "nanometre", false},
                                                {1e-6, "micrometre", false},
                                                {0.1, "decimetre", false},
                                                {10, "decametre", false},
                                                {100, "hectometre", false},
                                                {0, "gigametre", false},
                                                {0, "astronomical unit", false},
                                                {0, "light year", false},
                                                {0, "parsec", false},
                                                {1200.0 / 3937, "US survey foot", false},
                                                {100.0 / 3937, "US survey inch", false},
                                                {3600.0 / 3937, "US survey yard", false},
                                                {6336000.0 / 3937, "US survey mile", false}}};
  std::istringstream in(textOf(file, 1 << 20));  // the header comes first
  std::string line;
  while (std::getline(in, line))
    if (line.find("$INSUNITS") != std::string::npos) {
      int code = 0;
      long unit = 0;
      if (!(in >> code >> unit) || code != 70) return {};
      if (unit >= 0 && unit < static_cast<long>(kUnits.size()))
        return kUnits[static_cast<size_t>(unit)];
      return {0, "unit with number " + std::to_string(unit), false};
    }
  return {};
}

/// Unit of a Collada file: <unit name="inch" meter="0.0254"/>. assimp applies it.
FileUnit colladaUnit(const std::string& file) {
  std::string text = textOf(file, 1 << 16);  // the assets come first
  for (size_t begin = text.find("<!--"); begin != std::string::npos; begin = text.find("<!--")) {
    const size_t end = text.find("-->", begin);
    text.erase(begin, end == std::string::npos ? end : end + 3 - begin);
  }
  const size_t tag = text.find("<unit");
  const size_t end = text.find('>', tag);
  if (tag == std::string::npos || end == std::string::npos) return {};
  const auto valueOf = [&](const std::string& name) -> std::string {
    for (size_t at = text.find(name + "=", tag); at < end; at = text.find(name + "=", at + 1)) {
      const size_t first = at + name.size() + 2;
      if (std::isspace(static_cast<unsigned char>(text[at - 1])) != 0 && first < end)
        return text.substr(first, text.find(text[first - 1], first) - first);
    }
    return "";
  };
  FileUnit unit;
  const std::string metres = valueOf("meter");
  std::from_chars(metres.data(), metres.data() + metres.size(), unit.metres);
  if (!std::isfinite(unit.metres) || unit.metres <= 0) {
    unit.name = valueOf("name");
    unit.metres = unit.name == "meter" || unit.name == "metre" ? 1 : 0;
    return unit;
  }
  unit.name = valueOf("name");
  if (unit.name.empty()) unit.name = "unit of " + metres + " m";
  unit.is_applied = true;
  return unit;
}

/// Last bytes of a file.
std::string tailOf(const std::string& file, std::streamoff most) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = in.tellg();
  in.seekg(std::max<std::streamoff>(0, size - most));
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The last line that is not empty, without blanks before it.
std::string lastLineOf(const std::string& text) {
  const size_t last = text.find_last_not_of(" \t\r\n");
  if (last == std::string::npos) return "";
  const size_t before = text.find_last_of("\r\n", last);
  const size_t first = text.find_first_not_of(" \t", before == std::string::npos ? 0 : before + 1);
  return text.substr(first, last + 1 - first);
}

/// Whether a PLY file of text has fewer lines than its header announces. assimp reads the part that
/// is there. It refuses a binary file that is too short.
bool textPlyEndsTooEarly(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  bool is_text = false;
  uint64_t announced = 0;
  while (std::getline(in, line) && line.rfind("end_header", 0) != 0) {
    std::istringstream words(line);
    std::string first, second;
    uint64_t count = 0;
    words >> first >> second >> count;
    if (first == "format") is_text = second == "ascii";
    if (first == "element") announced += count;
  }
  if (!is_text) return false;
  uint64_t lines = 0;
  while (lines < announced && std::getline(in, line))
    lines += line.find_first_not_of(" \t\r") != std::string::npos ? 1 : 0;
  return lines < announced;
}

}  // namespace

std::string extensionOf(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool isCadFile(const std::string& file) {
  static const std::array<std::string_view, 6> kCad{".step", ".stp",  ".iges",
                                                    ".igs",  ".brep", ".brp"};
  return std::find(kCad.begin(), kCad.end(), extensionOf(file)) != kCad.end();
}

void requireReadableFormat(const std::string& file) {
  struct Format {
    const char *extension, *name, *way;
  };
  static constexpr const char* kFreeCad = "FreeCAD opens it and exports an OBJ file";
  static constexpr const char* kOwnProgram =
      "export an IFC2x3, FBX or OBJ file from the program that wrote it";
  static const std::array<Format, 9> kForeign{{{".fcstd", "a FreeCAD file", kFreeCad},
                                               {".rvt", "a Revit file", kOwnProgram},
                                               {".pln", "an ArchiCAD file", kOwnProgram},
                                               {".skp", "a SketchUp file", kOwnProgram},
                                               {".dwg", "a DWG file", kOwnProgram},
                                               {".3dm", "a Rhino file", kOwnProgram},
                                               {".max", "a 3ds Max file", kOwnProgram},
                                               {".usd", "a USD file", kOwnProgram},
                                               {".usdz", "a USD file", kOwnProgram}}};
  const std::string extension = extensionOf(file);
#ifndef EDGE_MCL_HAS_OCCT
  if (isCadFile(file))
    throw InputError(
        file + ": this build has no OpenCASCADE, which reads STEP, IGES and BREP: " + kFreeCad);
#endif
  for (const Format& f : kForeign)
    if (extension == f.extension)
      throw InputError(file + ": this is " + f.name + ", which cannot be read here: " + f.way);
  if (extension != ".ifc") return;
  const std::string schema = ifcSchema(file);
  if (schema.empty())
    throw InputError(file + ": the file has no IFC header that names its schema (FILE_SCHEMA)");
  if (schema.rfind("IFC2X", 0) != 0)
    throw InputError(file + ": the schema is " + schema +
                     ", and only IFC2X3 can be read here. Convert the file with IfcConvert of "
                     "IfcOpenShell: IfcConvert --use-element-names " +
                     file + " building.obj");
}

FileUnit statedUnit(const std::string& file) {
  const std::string extension = extensionOf(file);
  if (extension == ".ifc") return ifcUnit(file);
  if (extension == ".dxf") return dxfUnit(file);
  if (extension == ".dae") return colladaUnit(file);
  return {};
}

bool endsTooEarly(const std::string& file) {
  constexpr std::streamoff kTail = 4096;  // comments may follow the mark
  const std::string extension = extensionOf(file);
  const auto lacks = [&](const char* mark) {
    return tailOf(file, kTail).find(mark) == std::string::npos;
  };
  const std::string begin = textOf(file, 512);
  if (extension == ".ifc" || extension == ".step" || extension == ".stp")
    return lacks("END-ISO-10303-21");
  // A binary DXF has no line of text at its end.
  if (extension == ".dxf") return begin.rfind("AutoCAD Binary DXF", 0) != 0 && lacks("EOF");
  // The comment of a binary STL file may begin with the word, too.
  if (extension == ".stl")
    return begin.rfind("solid", 0) == 0 && begin.find("facet") != std::string::npos &&
           lastLineOf(tailOf(file, kTail)).rfind("endsolid", 0) != 0;
  return extension == ".ply" && textPlyEndsTooEarly(file);
}

}  // namespace edge_mcl
