#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "slipstream/image.h"

namespace slipstream {

/// Escapes & < > " as in HTML and XML.
std::string escaped(std::string_view text);

/// The answer of a report.
struct Verdict {
  const char* grade;  ///< "good", "usable" or "bad"
  std::string words;  ///< one sentence
};

/// How a front end shows texts that name settings in backquotes, see Error; null: as they are.
using Wording = std::string (*)(std::string_view text);

/// Names and values about the subject of a report.
using Facts = std::vector<std::pair<std::string, std::string>>;

/// A report as a web page, built part by part; it prints well. All texts are escaped.
class Page {
 public:
  explicit Page(std::string_view title, Wording wording = nullptr);

  /// In a line, in the colour of its grade.
  void verdict(const Verdict& verdict);

  void heading(std::string_view text) { add("h2", text); }

  template <class... Values>
  void paragraph(fmt::format_string<Values...> format, Values&&... values) {
    add("p", fmt::format(format, std::forward<Values>(values)...));
  }

  /// A table of facts, a row each.
  void facts(const Facts& facts);

  /// A line to sign, for a printed report.
  void signature();

  /// Starts a table with those columns; rows follow.
  void table(const std::vector<std::string>& columns);
  void row(const std::vector<std::string>& cells) { cells_in("td", cells); }

  /// `file` is relative to the page's folder.
  void picture(std::string_view says, const std::string& file);
  void picture(std::string_view says, const std::string& file, Image<Colour> pixels) {
    picture(says, file);
    drawn_.emplace_back(file, std::move(pixels));
  }

  /// The document so far, with pictures named by their files.
  [[nodiscard]] std::string text() const {
    return text_ + (in_table_ ? table_end : "") + "</html>\n";
  }

  /// The files of all pictures.
  [[nodiscard]] const std::vector<std::string>& files() const { return files_; }

  /// File names and pixels of the pictures added with pixels.
  [[nodiscard]] const std::vector<std::pair<std::string, Image<Colour>>>& drawn() const {
    return drawn_;
  }

 private:
  static constexpr const char* table_end = "</tbody>\n</table>\n";

  void add(std::string_view element, std::string_view text);
  void cells_in(std::string_view element, const std::vector<std::string>& cells);
  /// A text as the front end shows it, escaped.
  [[nodiscard]] std::string shown(std::string_view text) const {
    return escaped(wording_ == nullptr ? std::string(text) : wording_(text));
  }
  void end_table() {
    if (std::exchange(in_table_, false)) text_ += table_end;
  }

  Wording wording_;
  std::string text_;
  bool in_table_ = false;
  std::vector<std::string> files_;
  std::vector<std::pair<std::string, Image<Colour>>> drawn_;
};

}  // namespace slipstream
