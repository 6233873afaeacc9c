#pragma once

#include <bit>
#include <string>

namespace slipstream {

static_assert(std::endian::native == std::endian::little,
              "clouds and meshes are written as they lie in memory");

/// Appends a number, or a few in a row, as they lie in memory.
template <class Numbers>
void append_bytes(std::string& bytes, const Numbers& numbers) {
  bytes.append(reinterpret_cast<const char*>(&numbers), sizeof(numbers));
}

}  // namespace slipstream
