#include "edge_mcl/localization/tracking/localizer_state.h"

namespace edge_mcl {

const char* nameOf(LocalizerState state) {
  switch (state) {
    case LocalizerState::kUninitialized:
      return "uninitialized";
    case LocalizerState::kConverging:
      return "converging";
    case LocalizerState::kTracking:
      return "tracking";
    case LocalizerState::kDegraded:
      return "degraded";
    case LocalizerState::kLost:
      return "lost";
    case LocalizerState::kSearching:
      return "searching";
  }
  return "?";
}

}  // namespace edge_mcl
