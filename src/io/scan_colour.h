#pragma once

#include <optional>
#include <vector>

#include "frames/point_colours.h"
#include "slipstream/frame_set.h"
#include "slipstream/image.h"
#include "slipstream/scan.h"
#include "slipstream/scan_files.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// Which frames of a sequence show the colours of the scene: the sinusoids of the shortest exposure
/// along the first axis, whose mean has no stripes; a code has no sinusoids, and all its frames
/// count. Frames after the last one of them are left out of the list.
std::vector<bool> frames_of_colour(const Sequence& sequence);

/// Sets the scan's colours, or those of its colour camera: of the pictures that `files` name, else
/// of the white picture, else of the frames. Balances them by the grey patch of `files`, else by
/// the colour camera's scanner file or, of the scan's own camera, by `known`. Throws Error if they
/// are not of the frames' size or the patch cannot be used.
///
/// `white`: the channels of the white picture, or no frame. `mean`: of the frames, see
/// frames_of_colour; empty if they are grey. `known`: the white balance of the scan's scanner.
void add_colour(Scan& scan, const ScanFiles& files, const FrameSet& white, Image<ColourLevels> mean,
                const std::optional<WhiteBalance>& known);

/// The factors that make the grey patch of a scan's colours grey. Throws Error without a patch or
/// colours, and as reading the scan.
WhiteBalance white_balance_of(const ScanFiles& files);

}  // namespace slipstream
