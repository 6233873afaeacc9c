#include "slipstream/io/folder_sink.h"

#include <fmt/format.h>

#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"

namespace slipstream {

std::filesystem::path pattern_file(const std::filesystem::path& folder, std::size_t n) {
  return folder / fmt::format("pattern_{:02}.png", n);
}

void FolderSink::load(std::vector<Image<std::uint8_t>> patterns) {
  require_patterns(patterns, size(), folder_.string());
  patterns_ = std::move(patterns);
}

void FolderSink::show(std::size_t n) {
  const Image<std::uint8_t>& pattern = patterns_.at(n);
  make_folder(folder_);
  write_image(pattern_file(folder_, n), pattern);
  ++shown_;
}

}  // namespace slipstream
