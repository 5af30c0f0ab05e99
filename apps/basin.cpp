#include "common_options.h"
namespace edge_mcl {
void addBasin(CLI::App*, Action*) {}
}  // namespace edge_mcl
