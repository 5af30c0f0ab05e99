/// Facts about a model file that its importer does not tell.
#pragma once

#include <string>

namespace edge_mcl {

/// Unit of length that a file states.
struct FileUnit {
  double metres = 0;  ///< 0: the file does not say
  std::string name;
  bool is_applied = false;  ///< assimp delivers metres already
};

/// Extension of a file in lower case, with its dot.
std::string extensionOf(const std::string& file);

/// Checks before import that the format can be read.
/// @throws InputError for a format or an IFC schema that no importer here reads, with a way to
///   convert the file.
void requireReadableFormat(const std::string& file);

/// Whether a file of a format that ends with a mark (IFC, DXF) lacks the mark, as after a download
/// that was cut off. A part of the model is missing then.
bool endsTooEarly(const std::string& file);

/// Reads the unit of an IFC file, where assimp ignores units such as foot and inch, and of a DXF
/// file
/// ($INSUNITS). Other formats are not looked at.
FileUnit statedUnit(const std::string& file);

}  // namespace edge_mcl
