/// Memory of programs that handle pictures for hours.
#pragma once

namespace edge_mcl {

/// Tells the C library to give large blocks back to the system when they are freed. Pictures are
/// asked for with an alignment, and glibc before 2.38 does not use such blocks again once they
/// are free (its bug 14581): a viewer's heap grew to gigabytes of which 2 % were in use.
/// Call it once, before the first picture.
void giveLargeBlocksBack();

}  // namespace edge_mcl
