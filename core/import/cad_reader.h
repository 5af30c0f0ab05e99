/// Internal. Reads files of CAD programs with OpenCASCADE.
#pragma once

#include <string>

#include "edge_mcl/core/import/raw_model.h"

namespace edge_mcl {

/// Reads a STEP, IGES or BREP file. Curved faces become triangles that are off by at most 2 mm.
/// Curves that bound no face become lines. Vertices are in metres, in double precision; BREP files,
/// which state no unit, are taken for millimetres, the unit of OpenCASCADE's programs. An object
/// has the name of its part. Like readScene() it may crash on a broken file.
/// @throws InputError that names the file when it cannot be read.
RawModel readCadFile(const std::string& file);

}  // namespace edge_mcl
