/// Heap settings of programs that handle pictures for hours.
#pragma once

namespace edge_mcl {

/// Makes the C library return large blocks to the system when they are freed. Pictures are
/// allocated with an alignment. glibc before 2.38 does not use freed blocks of this kind again
/// (glibc bug 14581). Without this setting the heap of a viewer grows to gigabytes of which 2 % are
/// in use. Call it once, before the first picture.
void giveLargeBlocksBack();

}  // namespace edge_mcl
