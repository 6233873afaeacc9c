#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/file.h"

namespace slipstream {

/// Where the directories of a TIFF file lie; each describes a picture.
struct TiffDirectories {
  std::vector<std::uint64_t> offsets{};  ///< of each directory, in their order
  std::vector<int> pages{};  ///< directories of pictures, not of reduced copies or masks
  std::string fault{};       ///< why further ones cannot be read; empty: these are all
  bool too_many = false;     ///< the fault is the limit of pages
};

/// The directories of the file at `path`, in one pass. Those of the last few files are remembered,
/// so that reading a stack page by page takes time in proportion to its pages.
std::shared_ptr<const TiffDirectories> tiff_directories(const std::filesystem::path& path,
                                                        const InputFile& file);

/// Offset of the directory of a page, counted from 0. nullopt: of the only picture. Throws Error,
/// without a file name, if there is no such page.
std::uint64_t directory_of_page(const TiffDirectories& directories, std::optional<int> page);

/// The file's header with `directory` as the first one.
std::vector<std::uint8_t> header_naming(const InputFile& file, std::uint64_t directory);

}  // namespace slipstream
