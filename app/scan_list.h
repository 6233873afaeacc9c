#pragma once

#include <vector>

#include "app/reconstruct_flags.h"
#include "slipstream/io/scan_list.h"

namespace slipstream::app {

/// The scans that are asked for: folders, recordings, and lists of them, whose names end in .txt.
/// --windows is the range of recordings without one of their own. A range ends at the end of its
/// recording, which is opened for that unless the list says end and cost; one that cannot be read
/// is one scan. Throws Error for a range that is none or has no window.
std::vector<ListedScans> listed_scans(const ReconstructFlags& flags);

}  // namespace slipstream::app
