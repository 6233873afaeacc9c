#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/ranges.h>

#include "slipstream/error.h"

namespace slipstream {

// Limits of reading, checked before memory is allocated, whatever a file declares. Listed in
// docs/reference/limits.md.

/// Bytes of scan.yaml, a scanner file, a rig file or each text in a recording.
inline constexpr std::uint64_t largest_text = std::uint64_t{1} << 20;

/// Bytes of a picture file.
inline constexpr std::uint64_t largest_picture_file = (std::uint64_t{2} << 30) - 1;

/// Bytes of a cloud or mesh file.
inline constexpr std::uint64_t largest_file = std::uint64_t{4} << 30;

/// For recordings, which are read frame by frame.
inline constexpr std::uint64_t no_limit = std::numeric_limits<std::uint64_t>::max();

/// Pixels of a picture or of a recorded frame.
inline constexpr std::uint64_t largest_picture = 160'000'000;

/// Bytes of all frames of a scan.
inline constexpr std::uint64_t largest_scan = std::uint64_t{4} << 30;

/// Scans of one run, over all lists and window ranges.
inline constexpr std::uint64_t most_scans = 10'000'000;

/// A file descriptor; closed by the destructor.
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

/// A regular file open for reading. Opening never blocks: pipes and devices are refused.
class InputFile {
 public:
  /// Throws Error with the file's name if it is missing, not a regular file, larger than `largest`
  /// bytes or unreadable; WorldError if the system cannot open any file now.
  explicit InputFile(const std::filesystem::path& path, std::uint64_t largest = largest_file);

  /// Bytes at the time of opening.
  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// Fills all parts from `offset` on; returns false if the file ends before. Throws WorldError if
  /// reading fails.
  [[nodiscard]] bool read(std::uint64_t offset,
                          std::initializer_list<std::span<std::uint8_t>> parts) const;

 private:
  std::filesystem::path path_;
  Descriptor descriptor_;
  std::uint64_t size_ = 0;
};

/// The bytes of `text`, which must outlive them.
std::span<const std::uint8_t> bytes_of(std::string_view text);

/// The bytes of a file. Throws as InputFile.
std::vector<std::uint8_t> read_file(const std::filesystem::path& path,
                                    std::uint64_t largest = largest_file);

/// The bytes without the byte order mark with which some programs begin UTF-8.
std::span<const std::uint8_t> without_mark(std::span<const std::uint8_t> bytes);

/// Reads a text as programs of any system save it: without a byte order mark, and with lines that
/// end in LF instead of CRLF. Throws as InputFile.
std::string read_text(const std::filesystem::path& path, std::uint64_t largest = largest_text);

/// CRC-32 as in zlib; `before`: the checksum of the preceding bytes.
std::uint32_t checksum(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

/// The same for a file's contents. Throws Error if the file is missing.
std::uint32_t checksum_of_file(const std::filesystem::path& path, std::uint32_t before = 0);

/// Throws Error, without a file name, if `frames` frames of `frame_bytes` exceed largest_scan.
void require_scan_fits(std::uint64_t frames, std::uint64_t frame_bytes);

/// When a file that is being written gets its own name.
enum class FileWriting : int {
  at_once,   ///< removed unless kept, and by remove_temporary_files
  over_time  ///< has its own name from the start if that is free or an empty file; stays even if
             ///< not kept; is synced while it grows, which bounds the page cache; a second one of
             ///< the same name, in any process, throws
};

/// The file that is written for an output's path: the target of a link, which need not exist;
/// otherwise the path. Throws WorldError if it is a device, a pipe or a folder, also behind a link.
std::filesystem::path output_target(const std::filesystem::path& path);

/// A file that is written under an unpredictable temporary name in the same folder and renamed once
/// it is on disk; an existing file stays until then, and passes on its permissions. Follows links:
/// the target is replaced. Each member throws WorldError: if the folder is missing or not writable,
/// if the name belongs to something other than a file, or if the disk is full.
class OutputFile {
 public:
  using Writing = FileWriting;

  /// Maximum of unsynced bytes with `over_time`, besides those of one write().
  static constexpr std::uint64_t most_unsynced = 64 << 20;

  explicit OutputFile(const std::filesystem::path& path, Writing writing = Writing::at_once);

  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  ~OutputFile();

  void write(std::initializer_list<std::span<const std::uint8_t>> parts);

  /// Returns once the bytes so far, and the name, would survive a power failure.
  void sync();

  /// Syncs, closes and renames the file. Throws if the disk has failed before.
  void keep() { keep_together({this}); }

  /// Keeps files that belong together, in this order. After a failure none appears, and existing
  /// files stay.
  static void keep_together(std::initializer_list<OutputFile*> files);

  /// After a failure: keeps the first `size` bytes with `over_time`. With 0 or `at_once`, keeps
  /// nothing, and an existing file stays. Returns the failure as one line, with the path of the
  /// bytes if they are not under the file's own name.
  std::string give_up(std::uint64_t size);

  /// Number of leading bytes that would survive a power failure.
  [[nodiscard]] std::uint64_t synced() const { return synced_; }

  /// Closes and removes the file.
  void discard() noexcept;

 private:
  void claim();
  void pass_on();
  void finish();
  void let_go() noexcept;
  [[noreturn]] void fail(int reason);

  std::filesystem::path path_, folder_;
  std::string name_{};  ///< current name
  Writing writing_;
  bool remembered_ = false;  ///< by remove_temporary_files
  bool swapped_ = false;     ///< the previous file has the temporary name
  int descriptor_ = -1;      ///< -1: closed
  int claimed_ = -1;         ///< locked while this writes over time
  int disk_failure_ = 0;     ///< errno, which the system reports only once
  std::string failure_{};    ///< the first failure, without the path of the bytes

  /// Bytes in the file, handed to the disk, and synced.
  std::uint64_t written_ = 0, passed_on_ = 0, synced_ = 0;
};

/// A file that grows line by line, locked by one process. Each member throws WorldError.
class GrowingFile {
 public:
  /// Opens or creates the file. If another process has it locked, calls `waits` and waits for it;
  /// does not wait on file systems without locks.
  GrowingFile(const std::filesystem::path& path, const std::function<void()>& waits);

  /// Truncates the file to `size` bytes.
  void cut(std::uint64_t size);

  /// If that fails, as on a full disk, part of the line may have been written.
  void append(std::string_view line);

 private:
  void require(bool done) const;

  std::filesystem::path path_;
  Descriptor descriptor_;
};

/// The path that stands for standard output.
inline constexpr const char* standard_output = "-";

/// Writes a file atomically, or to standard_output. Throws as OutputFile.
void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

/// Returns read(); prefixes an Error's message with `name`, such as a file's.
template <class Read>
auto naming(const std::string& name, const Read& read) try {
  return read();
} catch (const Error& error) {
  throw Error(fmt::format("{}: {}", name, error.what()));
}

/// Removes files being written `at_once`. For a signal handler that then ends the program.
void remove_temporary_files() noexcept;

/// Creates a folder and its parents. Throws WorldError if that fails.
void make_folder(const std::filesystem::path& folder);

/// A path's ending in lower case: ".png", or empty.
std::string lower_case_extension(const std::filesystem::path& path);

/// Throws Error unless the path has one of these endings; `kind` names the format in the message.
void require_ending(const std::filesystem::path& path, const char* kind,
                    std::initializer_list<std::string_view> endings);

}  // namespace slipstream
