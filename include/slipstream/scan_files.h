#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/frame_source.h"
#include "slipstream/scan.h"
#include "slipstream/sequence.h"

namespace slipstream {

class RecordingReader;

/// The channel of colour pictures that becomes their grey levels.
enum class GreyChannel {
  by_light,  ///< grey, or the channel whose levels change clearly more: of coloured light
  grey,      ///< by the weights of ITU-R BT.601
  red,
  green,
  blue,
};

/// "red"; "auto" for by_light.
std::string_view name_of(GreyChannel channel);

/// Throws Error for any other name.
GreyChannel grey_channel_named(std::string_view name);

/// Description of a scan, from a scan.yaml or a recording, and its files.
struct ScanFiles {
  std::filesystem::path path{};  ///< the folder or the recording
  bool described = false;        ///< whether the sequence is known
  Sequence sequence{};
  int bits = 0;                                 ///< of the camera; 0 if unknown
  GreyChannel channel = GreyChannel::by_light;  ///< of colour pictures that show one pattern each
  std::vector<std::filesystem::path> frames{};  ///< pictures or pages; empty for a recording
  std::vector<int> order{};  ///< frame index of each pattern; empty: in stored order

  /// The colours of the first two pixels in raw pictures of a colour camera, e.g. "RG"; else
  /// empty.
  std::string mosaic{};
  Temperatures temperatures{};  ///< of the camera when the scan was taken; empty if unknown
  /// Colours of the points: a colour picture, or three grey ones under red, green and blue light.
  /// Empty: the mean of the frames, if these are in colour.
  std::vector<std::filesystem::path> colour{};
  /// Scanner file of the camera that took `colour`, if it is another than the scan's: of that
  /// camera and the same projector, or of the scan's camera and that one as a pair.
  std::optional<std::filesystem::path> colour_scanner{};
  /// A place of one grey, by which the colours are balanced instead of the scanner's white balance.
  std::optional<Rectangle> grey_patch{};

  std::shared_ptr<const RecordingReader> recording{};  ///< the open recording, or null

  /// Window of a recording, see window_at; nullopt: first cycle. Window of a folder of many frames,
  /// whose `frames` are then those of the window; nullopt: all.
  std::optional<std::uint64_t> window{};

  std::optional<std::filesystem::path> scanner{};  ///< the scanner file, or the recording
  /// The part of the calibrated picture that the frames show; nullopt: all. If they are a whole
  /// fraction of its size, their pixels join several (binning).
  std::optional<Rectangle> camera_region{};

  /// For colour pictures: a picture under uniform grey light, see unmixed.
  std::optional<std::filesystem::path> white{};

  /// The scan folders of further cameras for the same projector and time.
  std::vector<std::filesystem::path> further_cameras{};

  /// The scan folder of the guard, see Scan::guard.
  std::optional<std::filesystem::path> guard{};
};

/// A scan folder as read once for all its windows: its description without frames, and these.
struct ListedFolder {
  ScanFiles description{};
  std::vector<std::filesystem::path> frames{};
};

/// Overrides of a folder's or recording's description.
struct ScanChanges {
  SequenceChanges sequence{};

  /// Frame index of each pattern, from 0, e.g. "2,0,1", or the kinds in order, e.g.
  /// "code,sinusoids". Empty: unchanged.
  std::string order{};

  /// The recording, if already open, e.g. for another window.
  std::shared_ptr<const RecordingReader> recording{};

  /// The folder, if already listed, for a window of it.
  std::shared_ptr<const ListedFolder> folder{};

  std::optional<std::uint64_t> window{};
  std::optional<int> bits{};
  std::optional<GreyChannel> channel{};
  std::string mosaic{};  ///< as in ScanFiles, also e.g. "RGGB" or "BayerRG8"; empty: unchanged
  std::optional<Rectangle> grey_patch{};
  std::optional<std::filesystem::path> scanner{};
  std::optional<Rectangle> camera_region{};

  /// Scan folders or recordings of further cameras, and the scanner file of each; empty: unchanged.
  std::vector<std::filesystem::path> further_cameras{}, further_scanners{};
};

/// Number of windows: of the recording, or of the pictures, each cycle with its motion frames.
std::uint64_t window_count(const ScanFiles& files);

/// Lists a scan folder of many windows, so that each can be read without listing it again. Throws
/// Error if it is not a folder of pictures.
ListedFolder listed_folder(const std::filesystem::path& path);

/// The scan in a folder, described by its scan.yaml or its picture names, or in a recording, with
/// `changes`. Throws Error if `path` is neither, and as amend.
ScanFiles scan_files_in(const std::filesystem::path& path, const ScanChanges& changes = {});

/// Loads the frames and sequence of a scan, with exposures merged, without the scanner (read only
/// to separate colour channels). From a recording, loads the first complete cycle. Throws Error
/// with the path if frames cannot be read or do not match the strategy's number, or for an invalid
/// order.
Scan load_frames(const ScanFiles& files);

/// Whether the files are colour pictures of three frames each.
bool is_in_colour(const ScanFiles& files);

/// Loads one camera's frames, sequence and, if `files` names it, scanner, completed and validated
/// against the frames, with its guard, if any. Throws Error if a part cannot be read or does not
/// fit; the scanner is optional.
Scan load_scan(const ScanFiles& files);

/// The same for colour pictures, neither separated nor merged; `white` receives the channels of the
/// white picture, if any. Also throws Error if an order is set.
Scan load_as_taken(const ScanFiles& files, FrameSet& white);

/// Loads the complete scan in a folder or recording, with any further cameras, whose sequence must
/// be the same; see scan_files_in.
Scan load_scan(const std::filesystem::path& path, const ScanChanges& changes = {});

/// The poses in a folder, in natural order of their names. Each pose is a folder that contains
///   - scans x and y: folders, with or without scan.yaml, or recordings x.slip and y.slip; or
///   - the pictures of both scans, first along `first_axis`, in order of their names.
/// Skips folders with a report.html. A folder that contains x and y itself is the only pose. Throws
/// Error without poses, for a folder of neither kind, and as scan_files_in. Frames are read later,
/// as by load_frames.
std::vector<BoardScans> board_scans(const std::filesystem::path& folder, const ScanChanges& changes,
                                    Axis first_axis);

/// What a saved scan holds beside its frames and their sequence.
struct SavedParts {
  std::optional<Scanner> scanner{};                     ///< for its scanner.yaml
  std::optional<std::filesystem::path> scanner_file{};  ///< an existing file, instead of `scanner`

  bool in_colour = false;       ///< three frames per picture, see colour_channels.h
  FrameSet white{};             ///< in colour: channels of a white picture; may be empty
  Temperatures temperatures{};  ///< of the camera
};

/// Writes a scan to a folder, instead of one that is there: frames as frame_00.png and so on (.tiff
/// if unquantised), scan.yaml, and scanner.yaml if the scanner is known, or a reference to its
/// existing file. If the path ends in .slip, writes a recording of one cycle. Returns the files.
/// Throws Error for a recording of unquantised frames, and as require_as_taken, before writing.
ScanFiles save_scan(const std::filesystem::path& path, const FrameViews& frames,
                    const Sequence& sequence, const SavedParts& parts = {});

/// Writes a guard into the folder of a saved scan, as a scan of its own in guard/, and names it in
/// the scan's scan.yaml.
void save_guard(ScanFiles& scan, const FrameViews& frames, const Sequence& guard);

/// A free path in `parent`, named by the time: "WHAT-20260131-142530ENDING".
std::filesystem::path path_named_by_time(const std::filesystem::path& parent, std::string_view what,
                                         std::string_view ending);

/// Checksum over all files of a scan: scan.yaml, frames, scanner file, guard and further cameras;
/// for a recording, its header and the frames of the window. Throws Error if one is missing.
std::uint32_t checksum_of(const ScanFiles& scan);

}  // namespace slipstream
