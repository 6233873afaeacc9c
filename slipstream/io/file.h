#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

// The most that is read of a file, whatever it says of itself, looked at before memory is taken.
// docs/reference/limits.md states them.

/// Bytes of scan.yaml, a scanner file or a rig file, and of each text in a recording.
inline constexpr std::uint64_t largest_text = std::uint64_t{1} << 20;
/// Bytes of a picture's file.
inline constexpr std::uint64_t largest_picture_file = (std::uint64_t{2} << 30) - 1;
/// Bytes of a cloud's or mesh's file.
inline constexpr std::uint64_t largest_file = std::uint64_t{4} << 30;
/// Of a recording's file: it is read frame by frame.
inline constexpr std::uint64_t no_limit = std::numeric_limits<std::uint64_t>::max();
/// Pixels of a picture or of a recording's frames.
inline constexpr std::uint64_t largest_picture = 160'000'000;
/// Bytes of the pixels of all frames of a scan.
inline constexpr std::uint64_t largest_scan = std::uint64_t{4} << 30;
/// Scans of one run, by lists and ranges of windows.
inline constexpr std::uint64_t most_scans = 10'000'000;

/// A file's number for the system, which is closed in the end.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();

  operator int() const { return number_; }  // NOLINT(google-explicit-constructor)

 private:
  int number_;
};

/// A regular file that is read. Opening never waits: a pipe or a device is refused.
class InputFile {
 public:
  /// Throws Error, naming the file, where it is missing, no regular file, larger than `largest`
  /// bytes or unreadable.
  explicit InputFile(const std::filesystem::path& path, std::uint64_t largest = largest_file);

  /// Bytes, when it was opened.
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Fills all parts from that offset on; false where the file ends before. Throws WorldError
  /// where the disk does not give it.
  [[nodiscard]] bool read(std::uint64_t offset,
                          std::initializer_list<std::span<std::uint8_t>> parts) const;

 private:
  std::filesystem::path path_;
  Descriptor descriptor_;
  std::uint64_t size_ = 0;
};

/// The bytes of a file. Throws as InputFile.
std::vector<std::uint8_t> read_file(const std::filesystem::path& path,
                                    std::uint64_t largest = largest_file);
/// A text of at most largest_text bytes. Throws as InputFile.
std::string read_text(const std::filesystem::path& path);

/// The CRC-32 of zlib, of bytes that come behind those of which `before` is.
std::uint32_t checksum(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);
/// The same of what a file holds. Throws Error where there is no such file.
std::uint32_t checksum_of_file(const std::filesystem::path& path, std::uint32_t before = 0);

/// Throws Error, which does not name the file, where so many frames of so many bytes are more than
/// largest_scan.
void require_scan_fits(std::uint64_t frames, std::uint64_t frame_bytes);

/// A file that is written under a temporary name beside its own, which nobody can foresee, and that
/// has its own once it is on the disk: what was there before is there until then. Each member
/// throws WorldError: when the folder is missing or not writable, when something other than a file
/// has the name, when the disk is full.
class OutputFile {
 public:
  enum class Writing {
    at_once,   ///< gone where it is not kept, or by remove_temporary_files
    over_time  ///< under its own name from the start where that is free; stays, not kept too; goes
               ///< to the disk while it grows, and what is there leaves the memory
  };
  /// So many bytes at most that were written over time are not yet synced to the disk, beside those
  /// of one write().
  static constexpr std::uint64_t most_unsynced = 64 << 20;

  explicit OutputFile(const std::filesystem::path& path, Writing writing = Writing::at_once);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  void write(std::initializer_list<std::span<const std::uint8_t>> parts);
  /// Returns once what was written so far, and the name, would survive a loss of power.
  void sync();
  /// Syncs and closes the file and gives it its own name; not where the disk has failed before.
  void keep();
  /// After a failure: keeps so many bytes of what is written over time; with 0, or what is written
  /// at once, nothing, and what was there before stays.
  /// Returns what has failed, one line, which says where they are if not under the file's own name.
  std::string give_up(std::uint64_t size);
  /// Bytes, from the first on, that would survive a loss of power.
  [[nodiscard]] std::uint64_t synced() const { return synced_; }
  /// Closes and removes the file.
  void discard() noexcept;

 private:
  void pass_on();
  void let_go() noexcept;
  [[noreturn]] void fail_to_sync();
  [[noreturn]] void fail();

  std::filesystem::path path_, folder_;
  std::string name_{};  ///< under which it is written
  Writing writing_;
  bool remembered_ = false;  ///< by remove_temporary_files
  int descriptor_ = -1;      ///< once closed
  int disk_failure_ = 0;     ///< errno, which the system tells once; what was lost stays lost
  std::string failure_{};    ///< the first, without where the bytes are
  /// Bytes: in the file, of those on their way to the disk, and synced.
  std::uint64_t written_ = 0, passed_on_ = 0, synced_ = 0;
};

/// A file that grows line by line, of one process at a time. Each member throws WorldError.
class GrowingFile {
 public:
  /// Opens it, or makes it. While another process has it so, calls `waits`, and waits until that
  /// has ended; not on file systems that know no locks.
  GrowingFile(const std::filesystem::path& path, const std::function<void()>& waits);

  /// Cuts off what is behind so many bytes.
  void cut(std::uint64_t size);
  /// Where that fails, as on a full disk, a part of the line may be there.
  void append(std::string_view line);

 private:
  void require(bool done) const;

  std::filesystem::path path_;
  Descriptor descriptor_;
};

/// Writes a file whole or not at all. Throws as OutputFile.
void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

/// What `read` returns; an Error that it throws gets the name, as of a file, before its message.
template <class Read>
auto naming(const std::string& name, const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", name, error.what()));
  }
}

/// Removes what is being written at once. For a signal handler that then ends the program.
void remove_temporary_files() noexcept;

/// Makes a folder and those above it. Throws WorldError when that fails.
void make_folder(const std::filesystem::path& folder);

/// A path's ending in lower case: ".png". Empty where it has none.
std::string lower_case_extension(const std::filesystem::path& path);

/// Throws Error, "no KIND has the ending ...", unless the path's ending is one of these.
void require_ending(const std::filesystem::path& path, const char* kind,
                    std::initializer_list<std::string_view> endings);

}  // namespace slipstream
