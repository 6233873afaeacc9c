#include "slipstream/io/file.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// A file under a temporary name, removed again unless it is renamed to its own.
class TemporaryFile {
 public:
  explicit TemporaryFile(const fs::path& target)
      : target_(target),
        path_(fmt::format("{}.{}.part", target.string(), ::getpid())),
        descriptor_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0) fail();
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!renamed_) ::unlink(path_.c_str());
  }

  void write(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail();
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
  }

  void rename_to_target() {
    const int descriptor = std::exchange(descriptor_, -1);
    if (::close(descriptor) != 0) fail();
    if (::rename(path_.c_str(), target_.c_str()) != 0) fail();
    renamed_ = true;
  }

 private:
  [[noreturn]] void fail() const {
    throw WorldError(fmt::format("cannot write {}: {}", target_.string(), std::strerror(errno)));
  }

  fs::path target_;
  std::string path_;
  int descriptor_;
  bool renamed_ = false;
};

}  // namespace

std::vector<std::uint8_t> read_file(const fs::path& path) {
  if (!fs::exists(path)) throw Error(fmt::format("{}: no such file", path.string()));
  if (fs::is_directory(path)) {
    throw Error(fmt::format("{}: is a folder; a file is wanted", path.string()));
  }
  std::ifstream stream(path, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw Error(fmt::format("{}: cannot be read", path.string()));
  return bytes;
}

void write_file(const fs::path& path, std::span<const std::uint8_t> bytes) {
  TemporaryFile file(path);
  file.write(bytes);
  file.rename_to_target();
}

void write_file(const fs::path& path, std::string_view text) {
  write_file(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

void make_folder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure || !fs::is_directory(folder)) {
    throw WorldError(fmt::format("cannot make folder {}: {}", folder.string(),
                                 failure ? failure.message() : "a file has that name"));
  }
}

std::string lower_case_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

void require_ending(const fs::path& path, const char* kind,
                    std::initializer_list<std::string_view> endings) {
  const std::string ending = lower_case_extension(path);
  if (std::find(endings.begin(), endings.end(), ending) != endings.end()) return;
  throw Error(fmt::format("{}: no {} has the ending '{}'; use {}", path.string(), kind, ending,
                          fmt::join(endings, ", ")));
}

}  // namespace slipstream
