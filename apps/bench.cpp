#include "common_options.h"
namespace edge_mcl {
void addBench(CLI::App*, Action*) {}
}  // namespace edge_mcl
