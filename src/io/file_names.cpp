#include "io/file_names.h"

#include <chrono>
#include <ctime>

#include <fmt/chrono.h>
#include <fmt/format.h>

namespace slipstream {
namespace fs = std::filesystem;

fs::path free_path(const fs::path& path) {
  fs::path free = path;
  for (int copy = 2; fs::exists(free); ++copy) {
    free.replace_filename(
        fmt::format("{}-{}{}", path.stem().string(), copy, path.extension().string()));
  }
  return free;
}

fs::path path_named_by_time(const fs::path& parent, std::string_view what,
                            std::string_view ending) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return free_path(parent /
                   fmt::format("{}-{:%Y%m%d-%H%M%S}{}", what, fmt::localtime(now), ending));
}

}  // namespace slipstream
