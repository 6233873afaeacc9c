#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "io/pictures.h"

namespace slipstream {

/// A picture's file, and its page if the path names one, as FILE[2] does.
struct PicturePlace {
  std::filesystem::path file;
  std::optional<int> page{};
};

PicturePlace place_of(const std::filesystem::path& path);

/// Reads one picture of a scan with `frames` pictures. Throws Error with the file's name.
Picture read_picture(const std::filesystem::path& path, std::size_t frames = 1);

}  // namespace slipstream
