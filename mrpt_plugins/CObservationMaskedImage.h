/// An MRPT image observation with an ignore mask.
#pragma once

#include <mrpt/obs/CObservationImage.h>

namespace edge_mcl {

/// A CObservationImage with a mask of the pixels that show objects which are not in the map.
/// `cameraPose` is T_base_camera with the optical frame of the camera (x right, y down, z forward).
class CObservationMaskedImage : public mrpt::obs::CObservationImage {
  DEFINE_SERIALIZABLE(CObservationMaskedImage, edge_mcl)

 public:
  /// Mask, 8-bit grey, of the size of `image`; non-zero = ignored. Empty: nothing is ignored.
  mrpt::img::CImage ignore_mask;

  void getDescriptionAsText(std::ostream& o) const override;
};

}  // namespace edge_mcl
