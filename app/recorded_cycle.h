#pragma once

#include <filesystem>
#include <optional>

#include "slipstream/scan/scan.h"

namespace slipstream::app {

/// The first whole cycle of a recording as a scan, in pattern order as `slipstream live` would put
/// it, with the scanner where the recording knows it. None where it does not say what the frames
/// show, or where no cycle of its first frames is whole. Throws Error where the recording cannot be
/// read, or the scanner does not fit the frames.
std::optional<Scan> first_cycle(const std::filesystem::path& recording);

}  // namespace slipstream::app
