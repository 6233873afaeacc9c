#pragma once

#include <cstdint>
#include <span>

#include "io/opencv_storage.h"

namespace slipstream {

/// The arrays of NumPy's .npz by name; an empty entry if one is no small matrix of numbers.
/// Throws Error, without a file name, if the file is damaged.
StoredEntries npz_arrays(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
