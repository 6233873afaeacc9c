#pragma once

#include <filesystem>

#include "slipstream/sequence.h"

namespace slipstream {

class RecordingReader;

/// Description of a scan, from a scan.yaml or a recording, and its files.
struct ScanFiles {
  std::filesystem::path path{};  ///< the folder or the recording
  bool described = false;        ///< whether the sequence is known
  Sequence sequence{};
  int bits = 0;                                 ///< of the camera; 0 if unknown
  std::vector<std::filesystem::path> frames{};  ///< pictures or pages; empty for a recording
  std::vector<int> order{};  ///< frame index of each pattern; empty: in stored order

  std::shared_ptr<const RecordingReader> recording{};  ///< the open recording, or null

  /// Of a recording, see window_at; nullopt: first cycle. Of a folder of many frames, whose
  /// `frames` are then those of the window; nullopt: all.
  std::optional<std::uint64_t> window{};

  std::optional<std::filesystem::path> scanner{};  ///< the scanner file, or the recording

  /// For colour pictures: a picture under uniform grey light, see unmixed.
  std::optional<std::filesystem::path> white{};

  /// The scan folder of a second camera for the same projector and time.
  std::optional<std::filesystem::path> second_camera{};
};

/// Reads scan.yaml; resolves relative paths against its folder. Throws Error with file and key for
/// an unknown key, a missing one or a value out of range.
ScanFiles read_scan_files(const std::filesystem::path& file);

/// Parses the text of a scan.yaml as read_scan_files; `name`: the file's name in messages. `frames`
/// is optional.
ScanFiles scan_files_from(const std::string& text, const std::string& name,
                          const std::filesystem::path& folder);

/// Throws Error if the strategy's frames are derived rather than captured, see Strategy::read_as.
void require_as_taken(const Strategy& strategy);

/// The text of a scan.yaml in that folder, without `frames` if there are none. Throws Error as
/// require_as_taken.
std::string scan_yaml_of(const ScanFiles& scan, const std::filesystem::path& folder);

/// Writes scan.yaml, with frames and scanner relative to its folder.
void write_scan_files(const std::filesystem::path& file, const ScanFiles& scan);

/// Overrides of a folder's or recording's description.
struct ScanChanges {
  SequenceChanges sequence{};

  /// Frame index of each pattern, from 0, e.g. "2,0,1", or the kinds in order, e.g.
  /// "code,sinusoids". Empty: unchanged.
  std::string order{};

  /// The recording, if already open, e.g. for another window.
  std::shared_ptr<const RecordingReader> recording{};

  std::optional<std::uint64_t> window{};
  std::optional<int> bits{};
  std::optional<std::filesystem::path> scanner{};

  /// Scan folder or recording of a second camera, and its scanner's file.
  std::optional<std::filesystem::path> second_camera{}, second_scanner{};
};

/// Number of windows: of the recording, or of the pictures, each cycle with its motion frames.
std::uint64_t window_count(const ScanFiles& files);

/// Applies the changes. Throws Error if the sequence remains unknown, for unsupported bits, a
/// missing window of pictures and an invalid order.
void amend(ScanFiles& files, const ScanChanges& changes);

/// The scan in a folder, described by its scan.yaml or its picture names, or in a recording, with
/// `changes`. Throws Error if `path` is neither, and as amend.
ScanFiles scan_files_in(const std::filesystem::path& path, const ScanChanges& changes = {});

/// The pictures of `wanted` patterns, in pattern order: all of the folder's, or those chosen by its
/// `order`, which may leave out others, such as a white picture. Throws Error for an invalid order
/// and for another number of pictures, with the likely extra ones and an order without them.
/// `what`: name of the scan in messages.
std::vector<std::filesystem::path> pattern_pictures(const ScanFiles& files, int wanted,
                                                    const std::string& what);

/// Whether `a` comes before `b` in natural order by name: board2 before board10.
bool before_in_order(const std::filesystem::path& a, const std::filesystem::path& b);

/// Whether a folder beside scans may be one: neither hidden nor a report, which has a report.html.
bool is_scan_folder(const std::filesystem::path& folder);

/// The pictures in a folder in natural order, frame_2 before frame_10: each page of a TIFF file, no
/// hidden files, and JPEGs only if all pictures are. Throws Error without a folder or pictures.
std::vector<std::filesystem::path> images_in_folder(const std::filesystem::path& folder);

}  // namespace slipstream
