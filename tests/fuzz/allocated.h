#pragma once

#include <cstdint>

namespace slipstream {

/// Bytes that this process has allocated so far, in all threads and libraries, freed ones too.
std::uint64_t allocated_bytes();

}  // namespace slipstream
