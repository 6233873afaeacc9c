#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/opencv_storage.h"

namespace slipstream {

/// The first bytes of an .npy file of version 1.0, and with them the length of its header.
inline constexpr std::string_view npy_magic{"\x93NUMPY\x01\x00", 8};
inline constexpr std::size_t npy_preamble = npy_magic.size() + 2;

/// The header of an .npy file, and the bytes of its numbers.
struct NpyHeader {
  std::string_view type{};   ///< "<f8"
  bool by_columns = false;   ///< the first index runs fastest
  std::vector<int> shape{};  ///< lengths, 0 or more; empty if the file has none
  std::span<const std::uint8_t> numbers{};
};

/// Borrows from `bytes`; nullopt unless they are an .npy file of version 1.0. Throws Error, without
/// a file name, if the header is truncated.
std::optional<NpyHeader> npy_header(std::span<const std::uint8_t> bytes);

/// An array of NumPy.
struct NumpyArray {
  std::vector<int> shape{};
  std::vector<double> numbers{};  ///< row by row; empty if it has none, or of another type
  bool has_objects = false;       ///< Python objects, such as lists of different lengths
};

/// The array of an .npy file. Throws Error, without a file name, if the file is damaged.
NumpyArray array_of_npy(std::span<const std::uint8_t> bytes);

/// The arrays of an .npz file by name; those of more than `largest` bytes are empty, and not
/// unpacked. Throws Error, without a file name, if the file is damaged, or the others have more
/// than 64 MiB together.
std::map<std::string, NumpyArray> arrays_of_npz(std::span<const std::uint8_t> bytes,
                                                std::uint64_t largest);

/// The arrays of a NumPy .npz file by name. The entry of an array that is not a small matrix of
/// numbers is empty.
/// Throws Error, without a file name, if the file is damaged.
StoredEntries npz_arrays(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
