#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"

namespace slipstream {

/// A Markdown report, built part by part.
class Page {
 public:
  explicit Page(std::string_view title) : text_(fmt::format("# {}\n", title)) {}

  void heading(std::string_view text) { text_ += fmt::format("\n## {}\n", text); }
  template <class... Values>
  void paragraph(fmt::format_string<Values...> format, Values&&... values) {
    text_ += fmt::format("\n{}\n", fmt::format(format, std::forward<Values>(values)...));
  }
  /// Starts a table with those columns; rows follow.
  void table(const std::vector<std::string>& columns) {
    text_ += '\n';
    row(columns);
    row(std::vector<std::string>(columns.size(), "---"));
  }
  void row(const std::vector<std::string>& cells) {
    text_ += fmt::format("| {} |\n", fmt::join(cells, " | "));
  }
  /// `file` is relative to the page's folder.
  void picture(std::string_view says, std::string_view file) {
    text_ += fmt::format("\n![{}]({})\n", says, file);
  }
  void picture(std::string_view says, std::string file, Image<Colour> pixels) {
    picture(says, file);
    pictures_.emplace_back(std::move(file), std::move(pixels));
  }
  [[nodiscard]] const std::string& text() const { return text_; }
  /// File names and pixels of the pictures added with pixels.
  [[nodiscard]] const std::vector<std::pair<std::string, Image<Colour>>>& pictures() const {
    return pictures_;
  }

 private:
  std::string text_;
  std::vector<std::pair<std::string, Image<Colour>>> pictures_;
};

}  // namespace slipstream
