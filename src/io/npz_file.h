#pragma once

#include <cstdint>
#include <span>

#include "io/opencv_storage.h"

namespace slipstream {

/// The arrays of a NumPy .npz file by name. The entry of an array that is not a small matrix of
/// numbers is empty.
/// Throws Error, without a file name, if the file is damaged.
StoredEntries npz_arrays(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
