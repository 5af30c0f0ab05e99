// edge_mcl_import FILE BYTES: reads a model file for importModel() and writes it to file
// descriptor 3.
#include <cstdlib>

#include "edge_mcl/core/import/file_facts.h"
#include "edge_mcl/core/import/importer_process.h"
#include "edge_mcl/core/import/scene_reader.h"
#ifdef EDGE_MCL_HAS_OCCT
#include "edge_mcl/core/import/cad_reader.h"
#endif

namespace {

edge_mcl::RawModel readModel(const std::string& file) {
#ifdef EDGE_MCL_HAS_OCCT
  if (edge_mcl::isCadFile(file)) return edge_mcl::readCadFile(file);
#endif
  return edge_mcl::readScene(file);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  edge_mcl::runImporter(argv[1], 3, std::strtoull(argv[2], nullptr, 10), readModel);
}
