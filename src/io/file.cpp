#include "io/file.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <random>
#include <string>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <libdeflate.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/system_failure.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// Names of files being written `at_once`. Whoever takes a name out of its slot, the owner or a
/// signal handler, has it exclusively.
std::array<std::atomic<std::string*>, 64> temporary_names{};

/// Replaces `before` by `after`; returns false if not found.
bool replace_name(std::string* before, std::string* after) {
  for (std::atomic<std::string*>& place : temporary_names) {
    std::string* there = before;
    if (place.compare_exchange_strong(there, after)) return true;
  }
  return false;
}

/// Bytes handed to the disk at a time.
constexpr std::uint64_t passed_on_at_once = 4 << 20;

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

int create(const std::string& name) {
  return ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
}

/// Opens a regular file without contents; returns -1 for any other.
int open_empty(const std::string& name) {
  const int descriptor =
      ::open(name.c_str(), O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (descriptor < 0) return -1;

  struct stat status {};
  const bool is_empty =
      ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_size == 0;
  if (is_empty) return descriptor;

  ::close(descriptor);
  return -1;
}

/// Returns false, with errno, if writing fails.
bool write_all(int descriptor, std::span<const std::uint8_t> rest) {
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    rest = rest.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

/// Exchanges two files in one step. Returns false if one is missing; some file systems cannot.
bool swap_names(const std::string& one, const fs::path& other) {
  return ::renameat2(AT_FDCWD, one.c_str(), AT_FDCWD, other.c_str(), RENAME_EXCHANGE) == 0;
}

/// Gives a new file the permissions of the file that it replaces; some file systems have none.
void keep_permissions(int descriptor, const fs::path& replaced) {
  struct stat before {};
  if (::stat(replaced.c_str(), &before) != 0) return;
  static_cast<void>(::fchmod(descriptor, before.st_mode & 0777));
}

/// Returns false, with errno, if data may not be on disk. Some file systems cannot tell.
bool is_synced(int descriptor) {
  int result = 0;
  do {
    result = ::fsync(descriptor);
  } while (result != 0 && errno == EINTR);
  return result == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP;
}

bool is_folder_synced(const fs::path& folder) {
  const Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return descriptor < 0 ? errno == EACCES : is_synced(descriptor);
}

}  // namespace

Descriptor::~Descriptor() {
  const int reason = errno;
  if (number_ >= 0) ::close(number_);
  errno = reason;
}

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

InputFile::InputFile(const fs::path& path, std::uint64_t largest)
    : path_(path), descriptor_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {
  const auto refuse = [&](const std::string& why) {
    throw Error(fmt::format("{}: {}", path.string(), why));
  };

  struct stat status {};
  if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) {
    if (is_system_failure(errno)) {
      throw WorldError(fmt::format("cannot read {}: {}", path.string(), std::strerror(errno)));
    }
    refuse(errno == ENOENT ? "no such file" : std::strerror(errno));
  }

  if (S_ISDIR(status.st_mode)) refuse("is a folder; expected a file");
  if (!S_ISREG(status.st_mode)) refuse("is a device or a pipe; expected a file");

  size_ = static_cast<std::uint64_t>(status.st_size);
  if (size_ > largest) refuse(fmt::format("has {} bytes; limit {}", size_, largest));
}

bool InputFile::read(std::uint64_t offset,
                     std::initializer_list<std::span<std::uint8_t>> parts) const {
  for (std::span<std::uint8_t> rest : parts) {
    while (!rest.empty()) {
      const ssize_t got =
          ::pread(descriptor_, rest.data(), rest.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) {
        throw WorldError(fmt::format("cannot read {}: {}", path_.string(), std::strerror(errno)));
      }

      if (got == 0) return false;
      offset += static_cast<std::uint64_t>(got);
      rest = rest.subspan(static_cast<std::size_t>(got));
    }
  }

  return true;
}

std::vector<std::uint8_t> read_file(const fs::path& path, std::uint64_t largest) {
  const InputFile file(path, largest);
  std::vector<std::uint8_t> bytes(file.size());

  throw_if(!file.read(0, {bytes}), "{}: became shorter while it was read", path.string());
  return bytes;
}

std::span<const std::uint8_t> without_mark(std::span<const std::uint8_t> bytes) {
  constexpr std::array<std::uint8_t, 3> mark{0xEF, 0xBB, 0xBF};
  const bool is_marked =
      bytes.size() >= mark.size() && std::ranges::equal(bytes.first(mark.size()), mark);
  return is_marked ? bytes.subspan(mark.size()) : bytes;
}

std::string read_text(const fs::path& path, std::uint64_t largest) {
  const std::vector<std::uint8_t> bytes = read_file(path, largest);
  std::string text;
  for (const std::uint8_t byte : without_mark(bytes)) {
    if (byte == '\n' && text.ends_with('\r')) text.pop_back();
    text += static_cast<char>(byte);
  }
  return text;
}

std::uint32_t checksum(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  return bytes.empty() ? before : libdeflate_crc32(before, bytes.data(), bytes.size());
}

std::uint32_t checksum_of_file(const fs::path& path, std::uint32_t before) {
  const InputFile file(path, no_limit);
  std::vector<std::uint8_t> bytes;

  // 1 MiB at a time, so that a file of any size fits into memory.
  for (std::uint64_t at = 0; at < file.size(); at += bytes.size()) {
    bytes.resize(std::min(file.size() - at, std::uint64_t{1} << 20));
    if (!file.read(at, {bytes})) break;
    before = checksum(bytes, before);
  }
  return before;
}

void require_scan_fits(std::uint64_t frames, std::uint64_t frame_bytes) {
  throw_if(frames > largest_scan / frame_bytes, "{} frames of {} bytes; limit of a scan: {} bytes",
           frames, frame_bytes, largest_scan);
}

fs::path output_target(const fs::path& path) {
  const auto refuse = [&](const std::string& why) {
    throw WorldError(fmt::format("cannot write {}: {}", path.string(), why));
  };

  // The kind of file behind all links.
  std::error_code unknown;
  const fs::file_status there = fs::status(path, unknown);
  if (fs::exists(there) && !fs::is_regular_file(there)) refuse("not a regular file");

  fs::path target = path;
  constexpr int most_links = 40;  // as in the kernel
  for (int links = 0; fs::is_symlink(target, unknown); ++links) {
    if (links == most_links) refuse(std::strerror(ELOOP));
    target = target.parent_path() / fs::read_symlink(target, unknown);
  }

  // Links in /proc/self/fd may lead to a file that has no name any more.
  if (fs::exists(there) && !fs::equivalent(path, target, unknown)) refuse("not a regular file");
  return target;
}

OutputFile::OutputFile(const fs::path& path, Writing writing)
    : path_(output_target(path)), folder_(folder_of(path_)), writing_(writing) {
  // 1. Written over time: under its own name if that is free or an empty file.
  if (writing == Writing::over_time) {
    name_ = path_.string();  // before the file exists, so that it is always removed
    descriptor_ = create(name_);
    if (descriptor_ < 0 && errno != EEXIST) fail(errno);
    claim();
    if (descriptor_ < 0) descriptor_ = open_empty(name_);  // locked, so it stays empty
  }

  if (descriptor_ >= 0) return;

  // 2. Otherwise under a temporary name in the same folder, which a rename can replace.
  std::random_device random;
  const std::string own = path_.filename().string().substr(0, 200);  // so that both names fit
  name_ = folder_ / fmt::format("{}.{:08x}{:08x}.part", own, random(), random());

  remembered_ = writing == Writing::at_once && replace_name(nullptr, &name_);
  descriptor_ = create(name_);

  if (descriptor_ >= 0) {
    keep_permissions(descriptor_, path_);
    return;
  }

  // No destructor follows a constructor that throws.
  const int reason = errno;
  discard();
  if (claimed_ >= 0) ::close(claimed_);
  fail(reason);
}

OutputFile::~OutputFile() {
  if (writing_ == Writing::at_once) discard();
  if (descriptor_ >= 0) ::close(descriptor_);
  if (claimed_ >= 0) ::close(claimed_);
}

/// Locks the file that has the name, new or old, until this object is destroyed. Some file systems
/// cannot.
void OutputFile::claim() {
  claimed_ = descriptor_ >= 0 ? ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0)
                              : ::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (claimed_ < 0 && is_system_failure(errno)) {
    // Without the lock a second recording could be written to it. Removes only a file made here.
    const int reason = errno;
    if (descriptor_ >= 0) discard();
    name_.clear();
    fail(reason);
  }
  if (claimed_ < 0 || ::flock(claimed_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;

  ::close(claimed_);
  if (descriptor_ >= 0) ::close(descriptor_);
  throw WorldError(
      fmt::format("cannot write {}: another recording is being written to it", path_.string()));
}

void OutputFile::write(std::initializer_list<std::span<const std::uint8_t>> parts) {
  for (const std::span<const std::uint8_t> part : parts) {
    if (!write_all(descriptor_, part)) fail(errno);
    written_ += part.size();
  }

  if (writing_ == Writing::at_once) return;

  if (written_ - passed_on_ >= passed_on_at_once) pass_on();
  if (written_ - synced_ >= most_unsynced) sync();
}

/// Starts writing the newest part to disk, and drops earlier parts from the page cache once they
/// are there. Otherwise each write needs free memory, for which the kernel blocks for milliseconds.
/// The system calls take 0 bytes, as the first time, to mean everything.
void OutputFile::pass_on() {
  const auto before = static_cast<off_t>(passed_on_), now = static_cast<off_t>(written_);
  const bool done =
      ::sync_file_range(descriptor_, before, now - before, SYNC_FILE_RANGE_WRITE) == 0 &&
      ::sync_file_range(descriptor_, 0, before, SYNC_FILE_RANGE_WRITE_AND_WAIT) == 0;

  // The system reports a disk failure only once, so sync() would miss it.
  if (!done && (errno == EIO || errno == ENOSPC || errno == EDQUOT)) fail(disk_failure_ = errno);

  ::posix_fadvise(descriptor_, 0, before, POSIX_FADV_DONTNEED);
  passed_on_ = written_;
}

void OutputFile::sync() {
  if (!is_synced(descriptor_)) fail(disk_failure_ = errno);
  if (!is_folder_synced(folder_)) fail(errno);
  synced_ = written_;
}

void OutputFile::keep_together(std::initializer_list<OutputFile*> files) {
  for (OutputFile* const file : files) file->finish();

  for (auto place = files.begin(); place != files.end(); ++place) {
    OutputFile& file = **place;

    // With several, an existing file gets the temporary name, to be put back after a failure.
    file.swapped_ = files.size() > 1 && swap_names(file.name_, file.path_);
    if (file.swapped_ || ::rename(file.name_.c_str(), file.path_.c_str()) == 0) continue;

    // A failure: undoes the renames so far, the last first.
    const int reason = errno;
    while (place != files.begin()) {
      const OutputFile& kept = **--place;
      if (!kept.swapped_ || !swap_names(kept.name_, kept.path_)) ::unlink(kept.path_.c_str());
    }

    file.fail(reason);
  }

  // All files have their names: drops the previous ones and syncs the folders.
  for (OutputFile* const file : files) {
    if (file->swapped_) ::unlink(file->name_.c_str());
    file->let_go();
    if (!is_folder_synced(file->folder_)) file->fail(errno);
    file->synced_ = file->written_;
  }
}

/// Syncs and closes.
void OutputFile::finish() {
  if (!is_synced(descriptor_) && disk_failure_ == 0) disk_failure_ = errno;
  // An interrupted close has closed the file, whose data are on disk.
  const bool closed = ::close(std::exchange(descriptor_, -1)) == 0 || errno == EINTR;

  if (disk_failure_ != 0) fail(disk_failure_);
  if (!closed) fail(errno);
}

std::string OutputFile::give_up(std::uint64_t size) {
  if (size == 0 || writing_ == Writing::at_once) {
    discard();
    return failure_;
  }

  // If this fails, readers still skip the incomplete rest.
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) == 0) written_ = size;

  try {
    keep();
    return failure_;
  } catch (const WorldError& failure) {
    return failure.what();
  }
}

void OutputFile::discard() noexcept {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  if (!name_.empty()) ::unlink(name_.c_str());
  let_go();
}

void OutputFile::let_go() noexcept {
  while (remembered_ && !replace_name(&name_, nullptr)) ::pause();  // a handler exits the program

  remembered_ = false;
  name_.clear();
}

void OutputFile::fail(int reason) {
  const std::string failure =
      fmt::format("cannot write {}: {}", path_.string(), std::strerror(reason));
  if (failure_.empty()) failure_ = failure;

  const bool stays = writing_ == Writing::over_time && !name_.empty() && name_ != path_;
  throw WorldError(failure + (stays ? "; the data before that are in " + name_ : ""));
}

GrowingFile::GrowingFile(const fs::path& path, const std::function<void()>& waits)
    : path_(output_target(path)),
      descriptor_(
          ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0666)) {
  require(descriptor_ >= 0);

  // EWOULDBLOCK: another process has the lock. Any other failure: a file system without locks.
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  waits();
  while (::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) continue;
}

void GrowingFile::cut(std::uint64_t size) {
  require(::ftruncate(descriptor_, static_cast<off_t>(size)) == 0);
}

void GrowingFile::append(std::string_view line) {
  require(write_all(descriptor_, bytes_of(line)));
}

void GrowingFile::require(bool done) const {
  if (done) return;
  throw WorldError(fmt::format("cannot write {}: {}", path_.string(), std::strerror(errno)));
}

void write_file(const fs::path& path, std::span<const std::uint8_t> bytes) {
  if (path == standard_output) {
    const bool written = std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size();
    if (!written || std::fflush(stdout) != 0) throw WorldError("cannot write to standard output");
    return;
  }

  OutputFile file(path);
  file.write({bytes});
  file.keep();
}

void write_file(const fs::path& path, std::string_view text) {
  write_file(path, bytes_of(text));
}

void remove_temporary_files() noexcept {
  for (std::atomic<std::string*>& place : temporary_names) {
    if (const std::string* const name = place.exchange(nullptr)) ::unlink(name->c_str());
  }
}

void make_folder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);

  if (failure || !fs::is_directory(folder)) {
    throw WorldError(fmt::format("cannot create folder {}: {}", folder.string(),
                                 failure ? failure.message() : "a file has that name"));
  }
}

std::string lower_case_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
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
