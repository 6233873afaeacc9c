#pragma once

#include <filesystem>

namespace slipstream {

/// The path with a number before the ending: "scanner-2.yaml". A slash at its end is dropped.
std::filesystem::path numbered(const std::filesystem::path& path, int number);

/// The path, with -2, -3 and so on before the ending if it exists. Another program may take it at
/// any time: see NewFile and make_free_folder.
std::filesystem::path free_path(const std::filesystem::path& path);

/// Creates a new folder with the first free name of free_path, and its parents; two programs never
/// get the same. Returns it. Throws WorldError.
std::filesystem::path make_free_folder(const std::filesystem::path& path);

/// A new, empty file with the first free name of free_path; two programs never get the same.
/// OutputFile writes to it as to a name that is free. The destructor removes it if it is still
/// empty.
class NewFile {
 public:
  /// Throws WorldError.
  explicit NewFile(const std::filesystem::path& wanted);

  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  ~NewFile();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace slipstream
