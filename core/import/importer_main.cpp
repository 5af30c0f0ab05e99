// edge_mcl_import FILE BYTES: reads a model file for importModel() and writes it to file
// descriptor 3.
#include <cstdlib>

#include "edge_mcl/core/import/importer_process.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  edge_mcl::runImporter(argv[1], 3, std::strtoull(argv[2], nullptr, 10));
}
