#include "io/file_names.h"

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

}  // namespace slipstream
