#include "common_options.h"
namespace edge_mcl {
void addRawlog(CLI::App*, Action*) {}
}  // namespace edge_mcl
