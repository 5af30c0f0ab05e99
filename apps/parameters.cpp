#include "common_options.h"
namespace edge_mcl {
void addParameters(CLI::App*, Action*) {}
}  // namespace edge_mcl
