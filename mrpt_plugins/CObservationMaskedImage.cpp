#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"

#include <mrpt/serialization/CArchive.h>

IMPLEMENTS_SERIALIZABLE(CObservationMaskedImage, CObservationImage, edge_mcl)

namespace edge_mcl {

uint8_t CObservationMaskedImage::serializeGetVersion() const { return 0; }

void CObservationMaskedImage::serializeTo(mrpt::serialization::CArchive& out) const {
  // The base class does not write its version here, so the version goes before its data.
  out << mrpt::obs::CObservationImage::serializeGetVersion();
  mrpt::obs::CObservationImage::serializeTo(out);
  const bool masked = !ignore_mask.isEmpty();
  out << masked;
  if (masked) out << ignore_mask;
}

void CObservationMaskedImage::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  uint8_t base_version = 0;
  in >> base_version;
  mrpt::obs::CObservationImage::serializeFrom(in, base_version);
  bool masked = false;
  in >> masked;
  if (masked)
    in >> ignore_mask;
  else
    ignore_mask = mrpt::img::CImage();
}

void CObservationMaskedImage::getDescriptionAsText(std::ostream& o) const {
  mrpt::obs::CObservationImage::getDescriptionAsText(o);
  o << "Ignore mask: " << (ignore_mask.isEmpty() ? "none" : "yes") << "\n";
}

}  // namespace edge_mcl
