#include "common_options.h"
namespace edge_mcl {
void addEvaluate(CLI::App*, Action*) {}
}  // namespace edge_mcl
