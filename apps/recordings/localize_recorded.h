/// edge-mcl localize on a bag or a rawlog.
#pragma once

#include "apps/recordings/recording_options.h"

namespace edge_mcl {

struct LocalizeOptions : RecordingOptions {
  std::string out = "est.txt", stats, overlay, plot;
  bool json = false;
};

/// Reads the recording as fast as it can, with the same result whatever that is.
int localizeRecorded(const LocalizeOptions& options);

}  // namespace edge_mcl
