/// What the localizer says of its pose.
#pragma once

namespace edge_mcl {

enum class LocalizerState { kUninitialized, kConverging, kTracking, kDegraded, kLost, kSearching };

/// "tracking" etc.
const char* nameOf(LocalizerState state);

}  // namespace edge_mcl
