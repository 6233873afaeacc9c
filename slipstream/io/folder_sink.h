#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/frames/pattern_sink.h"

namespace slipstream {

/// Where pattern n, from 0, is written in a folder of patterns: pattern_00.png, pattern_01.png, ...
std::filesystem::path pattern_file(const std::filesystem::path& folder, std::size_t n);

/// A folder into which each pattern is written when it is shown, as pattern_file says, for a
/// projector that somebody else feeds. Patterns are of any size.
class FolderSink : public PatternSink {
 public:
  /// The folder is made when the first pattern is shown.
  explicit FolderSink(std::filesystem::path folder) : folder_(std::move(folder)) {}

  [[nodiscard]] std::optional<Size> size() const override { return std::nullopt; }
  void load(std::vector<Image<std::uint8_t>> patterns) override;
  void show(std::size_t n) override;
  [[nodiscard]] std::uint64_t shown() const override { return shown_; }
  [[nodiscard]] std::string state() const override { return {}; }

 private:
  std::filesystem::path folder_;
  std::vector<Image<std::uint8_t>> patterns_;
  std::uint64_t shown_ = 0;
};

}  // namespace slipstream
