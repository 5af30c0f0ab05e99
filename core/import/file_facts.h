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

/// Whether a file is of a format that OpenCASCADE reads: STEP, IGES, BREP.
bool isCadFile(const std::string& file);

/// Checks before import that the format can be read.
/// @throws InputError for a format or an IFC schema that no importer here reads, with a way to
///   convert the file.
void requireReadableFormat(const std::string& file);

/// Whether a file was cut off, as by a download that broke: it lacks the mark at the end of its
/// format (IFC, STEP, DXF, STL of text), or has fewer lines than it announces (PLY of text).
bool endsTooEarly(const std::string& file);

/// Reads the unit of an IFC file, where assimp ignores units such as foot and inch, of a DXF file
/// ($INSUNITS) and of a Collada file. Other formats are not looked at. A unit with a name but
/// without a length is one whose length is not known.
FileUnit statedUnit(const std::string& file);

}  // namespace edge_mcl
