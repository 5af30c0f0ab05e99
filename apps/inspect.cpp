#include "common_options.h"
namespace edge_mcl {
void addInspect(CLI::App*, Action*) {}
}  // namespace edge_mcl
