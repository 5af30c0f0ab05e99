// Registers the classes of this library with MRPT when the library is loaded, linked or preloaded.
#include <mrpt/core/initializer.h>
#include <mrpt/rtti/CObject.h>

#include "edge_mcl/mrpt_plugins/CEdgeMap.h"
#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"

MRPT_INITIALIZER(registerAllClasses_edge_mcl) {
  mrpt::rtti::registerClass(CLASS_ID_NAMESPACE(CEdgeMap, edge_mcl));
  mrpt::rtti::registerClass(CLASS_ID_NAMESPACE(CObservationMaskedImage, edge_mcl));
}
