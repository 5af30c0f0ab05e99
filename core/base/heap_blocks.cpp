#include "edge_mcl/core/base/heap_blocks.h"

#include <malloc.h>

namespace edge_mcl {

void giveLargeBlocksBack() {
#ifdef __GLIBC__
  // A fixed threshold also ends its automatic growth up to 32 MB.
  mallopt(M_MMAP_THRESHOLD, 256 * 1024);
  mallopt(M_TRIM_THRESHOLD, 4 * 1024 * 1024);
#endif
}

}  // namespace edge_mcl
