/// An MRPT image observation with an ignore mask.
#pragma once

#include <mrpt/obs/CObservationImage.h>

namespace edge_mcl {

/// Everything of mrpt::obs::CObservationImage, and which of its pixels show things that are not in
/// the map. `cameraPose` is the optical frame (x right, y down, z forward) on the robot.
class CObservationMaskedImage : public mrpt::obs::CObservationImage {
  DEFINE_SERIALIZABLE(CObservationMaskedImage, edge_mcl)

 public:
  /// 8-bit grey, non-zero = ignore, same size as `image`; empty: nothing is ignored.
  mrpt::img::CImage ignore_mask;

  void getDescriptionAsText(std::ostream& o) const override;
};

}  // namespace edge_mcl
