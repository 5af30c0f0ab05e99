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

/// Factor of an SI prefix in the arguments of an IFCSIUNIT.
double prefixOf(const std::string& arguments) {
  static const std::array<std::pair<const char*, double>, 6> kPrefixes{{{".MICRO.", 1e-6},
                                                                        {".MILLI.", 1e-3},
                                                                        {".CENTI.", 1e-2},
                                                                        {".DECI.", 0.1},
                                                                        {".HECTO.", 100},
                                                                        {".KILO.", 1e3}}};
  for (const auto& [name, factor] : kPrefixes)
    if (upper(arguments).find(name) != std::string::npos) return factor;
  return 1;
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
      if (const std::string* si = argumentsOf(entities, base, "IFCSIUNIT")) value *= prefixOf(*si);
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
      if (si && isLength(*si)) return {prefixOf(*si), "", true};
      const std::string* unit = argumentsOf(entities, number, "IFCCONVERSIONBASEDUNIT");
      if (unit && isLength(*unit)) return convertedUnit(*unit, entities);
    }
  }
  return {};
}

/// Unit of a DXF file: group code 70 after $INSUNITS (DXF reference, HEADER section).
FileUnit dxfUnit(const std::string& file) {
  static const std::map<int, FileUnit> kUnits{
      {1, {0.0254, "inch", false}},      {2, {0.3048, "foot", false}},
      {4, {0.001, "millimetre", false}}, {5, {0.01, "centimetre", false}},
      {6, {1, "metre", false}},          {7, {1000, "kilometre", false}},
      {10, {0.9144, "yard", false}},     {14, {0.1, "decimetre", false}}};
  std::istringstream in(textOf(file, 1 << 20));  // the header comes first
  std::string line;
  while (std::getline(in, line))
    if (line.find("$INSUNITS") != std::string::npos) {
      int code = 0, unit = 0;
      in >> code >> unit;
      const auto it = kUnits.find(unit);
      return code == 70 && it != kUnits.end() ? it->second : FileUnit();
    }
  return {};
}

}  // namespace

std::string extensionOf(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

void requireReadableFormat(const std::string& file) {
  struct Format {
    const char *extension, *name, *way;
  };
  static constexpr const char* kFreeCad = "FreeCAD opens it and exports an OBJ file";
  static constexpr const char* kOwnProgram =
      "export an IFC2x3, FBX or OBJ file from the program that wrote it";
  static const std::array<Format, 14> kForeign{{{".step", "a STEP file", kFreeCad},
                                                {".stp", "a STEP file", kFreeCad},
                                                {".iges", "an IGES file", kFreeCad},
                                                {".igs", "an IGES file", kFreeCad},
                                                {".brep", "an OpenCASCADE file", kFreeCad},
                                                {".fcstd", "a FreeCAD file", kFreeCad},
                                                {".rvt", "a Revit file", kOwnProgram},
                                                {".pln", "an ArchiCAD file", kOwnProgram},
                                                {".skp", "a SketchUp file", kOwnProgram},
                                                {".dwg", "a DWG file", kOwnProgram},
                                                {".3dm", "a Rhino file", kOwnProgram},
                                                {".max", "a 3ds Max file", kOwnProgram},
                                                {".usd", "a USD file", kOwnProgram},
                                                {".usdz", "a USD file", kOwnProgram}}};
  const std::string extension = extensionOf(file);
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
  return {};
}

bool endsTooEarly(const std::string& file) {
  const std::string extension = extensionOf(file);
  const char* mark = extension == ".ifc"   ? "END-ISO-10303-21"
                     : extension == ".dxf" ? "EOF"
                                           : nullptr;
  if (mark == nullptr) return false;
  constexpr std::streamoff kTail = 4096;  // comments may follow the mark
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = in.tellg();
  in.seekg(std::max<std::streamoff>(0, size - kTail));
  std::string tail(std::istreambuf_iterator<char>(in), {});
  // A binary DXF has no line of text at its end.
  constexpr const char* kBinaryDxf = "AutoCAD Binary DXF";
  in.clear();
  in.seekg(0);
  std::string begin(std::char_traits<char>::length(kBinaryDxf), ' ');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return begin != kBinaryDxf && tail.find(mark) == std::string::npos;
}

}  // namespace edge_mcl
