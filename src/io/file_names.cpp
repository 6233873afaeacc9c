#include "io/file_names.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include "io/file.h"
#include "slipstream/error.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// The first of the path's names, itself, -2, -3 and so on, for which take(name) is true.
template <class Take>
fs::path first_name(const fs::path& path, const Take& take) {
  fs::path name = path;
  for (int copy = 2; !take(name); ++copy) name = numbered(path, copy);
  return name;
}

/// Whether a name was free and is taken now. Throws WorldError if it can be neither.
bool is_taken(bool done, const char* what, const fs::path& name) {
  if (!done && errno != EEXIST) {
    throw WorldError(fmt::format("cannot {} {}: {}", what, name.string(), std::strerror(errno)));
  }
  return done;
}

}  // namespace

fs::path numbered(const fs::path& path, int number) {
  const fs::path whole = path.has_filename() ? path : path.parent_path();
  const std::string name =
      fmt::format("{}-{}{}", whole.stem().string(), number, whole.extension().string());
  return whole.parent_path() / name;
}

fs::path free_path(const fs::path& path) {
  return first_name(path, [](const fs::path& name) { return !fs::exists(name); });
}

fs::path make_free_folder(const fs::path& path) {
  if (path.has_parent_path()) make_folder(path.parent_path());
  return first_name(path, [](const fs::path& name) {
    return is_taken(::mkdir(name.c_str(), 0777) == 0, "create folder", name);
  });
}

NewFile::NewFile(const fs::path& wanted)
    : path_(first_name(wanted, [](const fs::path& name) {
        const Descriptor file(::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
        return is_taken(file >= 0, "write", name);
      })) {}

NewFile::~NewFile() {
  std::error_code unknown;
  if (fs::file_size(path_, unknown) == 0) fs::remove(path_, unknown);
}

}  // namespace slipstream
