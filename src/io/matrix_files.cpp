#include "io/matrix_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/npz_file.h"
#include "io/scanner_layouts.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

bool is_npz(const fs::path& path) {
  return lower_case_extension(path) == ".npz";
}

/// The numbers of a text, a row in each line; empty if the text is not a matrix.
StoredMatrix matrix_in_text(const std::string& text) {
  StoredMatrix matrix;
  std::istringstream lines(text);

  for (std::string line; std::getline(lines, line);) {
    line.resize(std::min(line.find('#'), line.size()));
    for (const char mark : {',', ';', '[', ']'}) std::ranges::replace(line, mark, ' ');
    std::istringstream words(line);

    int columns = 0;
    for (std::string word; words >> word; ++columns) {
      const auto number = number_in<double>(word);
      if (!number) return {};
      matrix.numbers.push_back(*number);
    }

    if (columns == 0) continue;
    if (matrix.rows > 0 && columns != matrix.columns) return {};
    matrix.columns = columns;
    ++matrix.rows;
  }
  return matrix;
}

/// The lower-case words of a name: "projMatrix_1" is proj, matrix and 1.
std::set<std::string> words_in_name(std::string_view name) {
  std::set<std::string> words;
  std::string word;
  const auto end_word = [&] {
    if (!word.empty()) words.insert(std::exchange(word, ""));
  };

  bool was_lower = false;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    if (!std::isalnum(letter) || (std::isupper(letter) && was_lower)) end_word();
    if (std::isalnum(letter)) word += static_cast<char>(std::tolower(letter));
    was_lower = std::islower(letter) != 0;
  }
  end_word();
  return words;
}

using Words = std::initializer_list<const char*>;

bool has_one_of(const std::set<std::string>& words, Words wanted) {
  return std::ranges::any_of(wanted, [&](const char* word) { return words.contains(word); });
}

/// slipstream's name of a matrix that is named so; empty if the words do not say.
std::string_view own_name(const std::set<std::string>& words) {
  const ScannerLayout& own = scanner_layouts.front();

  const bool is_projector = has_one_of(words, {"projector", "proj", "pro", "prj", "p"});
  const LensNames& lens = is_projector ? own.projector : own.camera;
  if (has_one_of(words, {"distortion", "dist", "d", "kc", "coeffs", "coefficients"})) {
    return lens.distortion;
  }
  if (has_one_of(words, {"matrix", "k", "mtx", "intrinsic", "intrinsics", "int"})) {
    return lens.matrix;
  }

  if (has_one_of(words, {"r", "rot", "rotation"})) return own.rotation;
  if (has_one_of(words, {"t", "trans", "translation", "tvec"})) return own.translation;
  return {};
}

/// Whether a known tool has written all of the names.
bool has_known_names(const StoredEntries& entries) {
  return std::ranges::any_of(scanner_layouts, [&](const ScannerLayout& layout) {
    return has(entries, layout.camera.matrix) && has(entries, layout.projector.matrix) &&
           has(entries, layout.rotation) && has(entries, layout.translation);
  });
}

/// With slipstream's names where the names say which matrix they are. Throws Error if two say the
/// same.
StoredEntries with_own_names(const StoredEntries& entries) {
  StoredEntries renamed;
  for (const auto& [name, matrix] : entries) {
    const std::string_view own =
        matrix.empty() ? std::string_view() : own_name(words_in_name(name));
    const bool is_new = renamed.emplace(own.empty() ? name : std::string(own), matrix).second;
    throw_if(!is_new, "{} and another matrix are both {}; leave out one", name, own);
  }
  return renamed;
}

/// Throws Error with the names of the matrices if one is missing.
void require_complete(const StoredEntries& entries, const StoredEntries& renamed) {
  std::string there;
  for (const auto& [name, matrix] : entries) {
    if (!matrix.empty()) there += (there.empty() ? "" : ", ") + name;
  }

  const ScannerLayout& own = scanner_layouts.front();
  for (const std::string_view needed :
       {own.camera.matrix, own.projector.matrix, own.rotation, own.translation}) {
    throw_if(!has(renamed, needed),
             "no {} among its matrices {}; name them camera_matrix, camera_distortion, "
             "projector_matrix, projector_distortion, R and T",
             needed, there);
  }
}

}  // namespace

bool has_matrices(const fs::path& path) {
  std::error_code unknown;
  return is_npz(path) || fs::is_directory(path, unknown);
}

std::vector<fs::path> matrix_files(const fs::path& path) {
  if (is_npz(path)) return {path};

  constexpr std::array endings{".txt", ".csv", ".dat"};
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(path)) {
    const bool is_text = std::ranges::count(endings, lower_case_extension(entry.path())) > 0;
    if (is_text && entry.is_regular_file()) files.push_back(entry.path());
  }

  throw_if(files.empty(), "{}: a folder without text files of a calibration, such as R.txt",
           path.string());
  std::ranges::sort(files);
  return files;
}

StoredEntries read_matrices(const fs::path& path) {
  StoredEntries entries;
  if (is_npz(path)) {
    // The boards' corners may be in the file, too.
    constexpr std::uint64_t largest = 64 * largest_text;
    const std::vector<std::uint8_t> bytes = read_file(path, largest);
    entries = naming(path.string(), [&] { return npz_arrays(bytes); });
  } else {
    for (const fs::path& file : matrix_files(path)) {
      entries[file.stem().string()] = matrix_in_text(read_text(file));
    }
  }

  if (has_known_names(entries)) return entries;
  return naming(path.string(), [&] {
    StoredEntries renamed = with_own_names(entries);
    require_complete(entries, renamed);
    return renamed;
  });
}

}  // namespace slipstream
