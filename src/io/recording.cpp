#include "slipstream/recording.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <map>
#include <ranges>
#include <regex>
#include <string_view>
#include <system_error>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "frames/colour_channels.h"
#include "frames/scan_camera.h"
#include "io/file.h"
#include "io/recording_format.h"
#include "io/scan_folder.h"
#include "slipstream/scanner_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

using namespace recording_format;

/// Bytes at the end of an interrupted recording that are searched frame by frame: more than are
/// ever unsynced.
constexpr std::uint64_t searched_bytes = 4 * OutputFile::most_unsynced;

/// The texts after the header; nullopt if damaged.
std::optional<std::string> read_texts(const InputFile& file, const FileHeader& header) {
  const std::size_t size =
      std::size_t{header.scan_length} + header.scanner_length + header.white_length;

  // Limits first, so that a damaged header cannot make this allocate much.
  if (header.scan_length > largest_text || header.scanner_length > largest_text ||
      header.header_size != sizeof(header) + aligned(size) || header.header_size > file.size()) {
    return std::nullopt;
  }

  std::string texts(aligned(size), '\0');
  const std::span<std::uint8_t> bytes(reinterpret_cast<std::uint8_t*>(texts.data()), texts.size());
  const bool whole =
      file.read(sizeof(header), {bytes}) && header.checksum == checksum_of(header, bytes);

  return whole ? std::optional(std::move(texts)) : std::nullopt;
}

std::string text_of(const FrameFormat& format) {
  return fmt::format("{}x{} with {} bits", format.size.width, format.size.height, format.bits);
}

/// The concatenated pixels of the white picture's channels.
std::string pixels_of(const FrameSet& white) {
  std::string pixels;
  white.visit([&](const auto& views) {
    for (const auto& view : views) {
      // The frame set's rows are contiguous.
      const auto* const begin = reinterpret_cast<const char*>(view.row(0));
      const auto* const end = reinterpret_cast<const char*>(view.row(view.height()));
      pixels.append(begin, end);
    }
  });
  return pixels;
}

FrameSet white_from(std::string_view pixels, const FrameFormat& format) {
  if (pixels.empty()) return {};

  std::vector<Frame> frames(channels, Frame(format));
  for (Frame& frame : frames) {
    const std::span<std::uint8_t> own = pixel_bytes(frame);
    std::copy_n(pixels.begin(), own.size(), own.begin());
    pixels.remove_prefix(own.size());
  }

  return frame_set_of(std::move(frames));
}

void require_valid_colours(const RecordingHeader& header) {
  if (header.in_colour && header.sequence) {
    require_in_colour(*header.sequence, "a recording in colour");
  }

  const FrameSet& white = header.white;
  if (white.count() == 0) return;

  const FrameFormat format{white.size(), white.bits()};
  throw_if(!header.in_colour || white.count() != channels || !white.quantised() ||
               format != header.format,
           "a white picture of {} channels, {}, cannot be recorded with frames of {}; it needs "
           "three channels of the same format",
           white.count(), text_of(format), text_of(header.format));
}

void require_valid_header(const RecordingHeader& header) {
  require_valid(header.format);
  throw_if(!(header.frame_rate >= 0 && std::isfinite(header.frame_rate)),
           "frame rate {} Hz: expected 0 or more", header.frame_rate);

  require_valid_colours(header);
}

}  // namespace

bool is_recording(const fs::path& path) {
  std::array<char, recording_magic.size()> begin{};
  std::error_code unknown;
  return fs::is_regular_file(path, unknown) &&
         InputFile(path, no_limit).read(0, {writable_bytes_of(begin)}) && begin == recording_magic;
}

RecordingWriter::RecordingWriter(const fs::path& path, const RecordingHeader& header)
    : RecordingWriter(path, header, FileWriting::over_time) {}

RecordingWriter::RecordingWriter(const fs::path& path, const RecordingHeader& header,
                                 OutputFile::Writing writing)
    : path_(path), writing_(writing), format_(header.format) {
  require_valid_header(header);

  // 1. The texts behind the header: scan.yaml, scanner file and white picture.
  const std::string scan =
      header.sequence
          ? scan_yaml_of({.sequence = *header.sequence, .temperatures = header.temperatures}, {})
          : std::string();
  const std::string scanner = header.scanner ? text_of(*header.scanner) : std::string();
  throw_if(scanner.size() > largest_text,
           "scanner file of {} bytes is too large to record; limit {}", scanner.size(),
           largest_text);

  const std::string white = pixels_of(header.white);
  std::string texts = scan + scanner + white;
  texts.resize(aligned(texts.size()), '\0');  // aligns the first record
  header_size_ = sizeof(FileHeader) + texts.size();

  // 2. The header, with the checksum of both.
  FileHeader written{.recording_magic = recording_magic,
                     .version = header.in_colour ? colour_version : grey_version,
                     .header_size = static_cast<std::uint32_t>(header_size_),
                     .width = static_cast<std::uint32_t>(format_.size.width),
                     .height = static_cast<std::uint32_t>(format_.size.height),
                     .bits = static_cast<std::uint32_t>(format_.bits),
                     .scan_length = static_cast<std::uint32_t>(scan.size()),
                     .scanner_length = static_cast<std::uint32_t>(scanner.size()),
                     .channels = header.in_colour ? channels : 0,
                     .frame_rate = header.frame_rate,
                     .record_size = record_size(format_),
                     .white_length = static_cast<std::uint32_t>(white.size())};

  const Bytes text_bytes(reinterpret_cast<const std::uint8_t*>(texts.data()), texts.size());
  written.checksum = checksum_of(written, text_bytes);

  file_ = std::make_unique<OutputFile>(path, writing);

  try {
    file_->write({bytes_of(written), text_bytes});
  } catch (const WorldError&) {
    file_->discard();
    throw;
  }
}

bool RecordingWriter::keeps_frames() const {
  return count_ > 0 && writing_ == FileWriting::over_time;
}

RecordingWriter::~RecordingWriter() {
  try {
    if (!file_) return;
    if (keeps_frames()) {
      file_->keep();
    } else {
      file_->discard();
    }
  } catch (const std::exception&) {
    // A destructor must not throw; the frames written stay.
  }
}

void RecordingWriter::append(const Frame& frame) {
  if (!file_) throw Error(fmt::format("{}: the recording is closed", path_.string()));
  if (frame.format() != format_) {
    throw Error(fmt::format("{}: cannot record a frame of {} with frames of {}", path_.string(),
                            text_of(frame.format()), text_of(format_)));
  }

  // Host times are stored relative to the first frame's.
  if (count_ == 0) first_host_time_ = frame.stamp.host_time;

  RecordHeader header{
      .pattern_index = frame.stamp.pattern_index.value_or(-1),
      .index = count_,
      .sequence = frame.stamp.sequence,
      .device_time = frame.stamp.device_time.count(),
      .host_time = std::chrono::nanoseconds(frame.stamp.host_time - first_host_time_).count()};

  // The padding aligns the next record.
  const Bytes pixels = pixel_bytes(frame);
  const Bytes padding = Bytes(zeros).first(aligned(pixels.size()) - pixels.size());
  header.checksum = checksum_behind(header, pixels, padding);

  write({bytes_of(header), pixels, padding});
  ++count_;
}

std::uint64_t RecordingWriter::size_of(std::uint64_t frames) const {
  return header_size_ + frames * record_size(format_) + sizeof(End);
}

void RecordingWriter::finish() {
  if (!file_) throw Error(fmt::format("{}: the recording is closed", path_.string()));
  if (count_ == 0) return std::exchange(file_, nullptr)->discard();

  End end{.count = count_};
  end.checksum = checksum_behind(end);

  write({bytes_of(end)});
  std::exchange(file_, nullptr)->keep();
}

void RecordingWriter::write(std::initializer_list<Bytes> parts) try {
  file_->write(parts);
} catch (const WorldError&) {
  // Cuts off the incomplete record; the frames before it stay.
  const std::unique_ptr<OutputFile> file = std::exchange(file_, nullptr);
  const std::uint64_t record = record_size(format_);
  const bool keeps = keeps_frames();
  const std::string why = file->give_up(keeps ? header_size_ + count_ * record : 0);

  if (!keeps) throw WorldError(why);

  // Unsynced frames are in the file but may not survive a power failure.
  const std::uint64_t synced = std::max(file->synced(), header_size_) - header_size_;
  const std::uint64_t sure = std::min(count_, synced / record);

  throw WorldError(
      sure == count_
          ? fmt::format("{}; the {} frames before are recorded", why, count_)
          : fmt::format("{}; of the {} frames before, {} are safely on disk", why, count_, sure));
}

RecordingReader::~RecordingReader() = default;

RecordingReader::RecordingReader(const fs::path& path)
    : path_(path), file_(std::make_unique<InputFile>(path, no_limit)) {
  const std::string name = path.string();
  const auto [scan, scanner] = naming(name, [this] { return read_header(); });

  if (!scan.empty()) {
    const ScanFiles files = scan_files_from(scan, name, {});
    header_.sequence = files.sequence;
    header_.temperatures = files.temperatures;
  }
  if (!scanner.empty()) header_.scanner = scanner_from(scanner, name);

  find_end();
}

std::pair<std::string, std::string> RecordingReader::read_header() {
  // 1. Whether it is a recording that this version can read.
  FileHeader header;
  throw_if(
      !file_->read(0, {writable_bytes_of(header)}) || header.recording_magic != recording_magic,
      "is not a slipstream recording");
  throw_if(header.version != grey_version && header.version != colour_version,
           "has recording version {}; supported: {} and {}", header.version, grey_version,
           colour_version);

  header_.in_colour = header.version == colour_version;

  const auto require_whole = [](bool whole) {
    if (!whole) throw Error("its header is damaged");
  };

  // 2. The texts, whose checksum also covers the header.
  require_whole(header.channels == (header_.in_colour ? channels : 0));
  const std::optional<std::string> stored = read_texts(*file_, header);
  require_whole(stored.has_value());

  // 3. The frames' format.
  throw_if(std::uint64_t{header.width} * header.height > largest_picture,
           "frames of {}x{} pixels; limit {} pixels", header.width, header.height, largest_picture);
  header_.format = {{static_cast<int>(header.width), static_cast<int>(header.height)},
                    static_cast<int>(header.bits)};
  header_.frame_rate = header.frame_rate;
  require_valid_header(header_);

  const std::uint64_t white_length = header_.in_colour ? channels * byte_count(header_.format) : 0;
  require_whole(header.record_size == record_size(header_.format) &&
                (header.white_length == 0 || header.white_length == white_length));

  // 4. The texts' parts.
  std::string scan = stored->substr(0, header.scan_length);
  std::string scanner = stored->substr(header.scan_length, header.scanner_length);
  header_.white = white_from(
      std::string_view(*stored).substr(scan.size() + scanner.size(), header.white_length),
      header_.format);

  header_size_ = header.header_size;
  header_checksum_ = header.checksum;

  return {std::move(scan), std::move(scanner)};
}

void RecordingReader::find_end() {
  // 1. A finished recording ends with its number of frames.
  const std::uint64_t record = record_size(header_.format);
  const std::uint64_t size = file_->size() - header_size_, rest = size % record;
  count_ = size / record;

  End end;
  finished_ = rest == sizeof(end) && file_->read(file_->size() - rest, {writable_bytes_of(end)}) &&
              end.mark == end_mark && end.checksum == checksum_behind(end) && end.count == count_;

  if (finished_) return;

  // 2. An interrupted one: the last whole frame, searched from the end. After a power failure the
  // file may have its full length but not its last bytes.
  const std::uint64_t there = count_ + (rest > 0 ? 1 : 0);

  Frame frame;
  const auto is_whole = [&](std::uint64_t index) { return read(index, frame); };

  const std::uint64_t first = count_ - std::min(count_, searched_bytes / record + 1);
  while (count_ > first && !is_whole(count_ - 1)) --count_;

  // No whole frame there: the boundary between whole and missing ones, by bisection.
  if (count_ == first) {
    const auto before = std::views::iota(std::uint64_t{0}, count_);
    count_ =
        static_cast<std::uint64_t>(std::ranges::partition_point(before, is_whole) - before.begin());
  }

  dropped_ = there - count_;
}

bool RecordingReader::read(std::uint64_t index, Frame& frame) const {
  throw_if(index >= count_, "{}: no frame {}; it has {} frames", path_.string(), index, count_);

  RecordHeader header;
  const std::uint64_t offset = header_size_ + index * record_size(header_.format);
  if (!file_->read(offset, {writable_bytes_of(header)}) || header.index != index ||
      !is_possible(header.device_time) || !is_possible(header.host_time)) {
    return false;
  }

  if (frame.format() != header_.format) frame = Frame(header_.format);

  std::array<std::uint8_t, alignment> rest{};
  const std::span<std::uint8_t> pixels = pixel_bytes(frame);
  const std::span<std::uint8_t> padding =
      std::span(rest).first(aligned(pixels.size()) - pixels.size());

  if (!file_->read(offset + sizeof(header), {pixels, padding}) ||
      header.checksum != checksum_behind(header, Bytes(pixels), Bytes(padding))) {
    return false;
  }

  frame.stamp.sequence = header.sequence;
  frame.stamp.pattern_index =
      header.pattern_index < 0 ? std::nullopt : std::optional<int>(header.pattern_index);
  frame.stamp.device_time = std::chrono::nanoseconds(header.device_time);
  frame.stamp.host_time =
      std::chrono::steady_clock::time_point(std::chrono::nanoseconds(header.host_time));

  return true;
}

std::uint32_t RecordingReader::checksum(std::uint64_t first, std::uint64_t end,
                                        std::uint32_t before) const {
  std::uint32_t sum = slipstream::checksum(bytes_of(header_checksum_), before);

  // A record's header contains its pixels' checksum.
  RecordHeader header;
  for (std::uint64_t index = first; index < std::min(end, count_); ++index) {
    const std::uint64_t offset = header_size_ + index * record_size(header_.format);
    if (!file_->read(offset, {writable_bytes_of(header)})) break;
    sum = slipstream::checksum(bytes_of(header), sum);
  }
  return sum;
}

FileLimit file_limit_from(const std::string& text) {
  static const std::map<std::string, double> sizes{{"MB", 1e6}, {"GB", 1e9}, {"TB", 1e12}},
      times{{"s", 1}, {"min", 60}, {"h", 3600}};

  std::smatch parts;
  const bool fits = std::regex_match(text, parts, std::regex("([0-9.]+)([A-Za-z]+)(,ring)?"));
  const std::string unit = parts[2].str();
  const double number = number_in<double>(parts[1].str()).value_or(0);

  throw_if(!fits || !(number > 0 && number <= 1e6) || sizes.count(unit) + times.count(unit) == 0,
           "`limit` '{}': expected a size or time, e.g. 500MB, 20GB, 90s, 10min or 20GB,ring",
           text);

  FileLimit limit{.ring = parts[3].matched};
  if (times.contains(unit)) limit.seconds = number * times.at(unit);
  if (sizes.contains(unit)) limit.bytes = static_cast<std::uint64_t>(number * sizes.at(unit));

  return limit;
}

}  // namespace slipstream
