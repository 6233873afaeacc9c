#pragma once

#include <filesystem>

#include "slipstream/codes/sequence.h"

namespace slipstream {

class RecordingReader;

/// What a scan.yaml or a recording says of a scan, and the files that it is in.
struct ScanFiles {
  std::filesystem::path path{};  ///< the folder or the recording
  bool described = false;        ///< whether it says what the frames show
  Sequence sequence{};
  int bits = 0;                                 ///< of the camera; 0 where not said
  std::vector<std::filesystem::path> frames{};  ///< pictures; none where it is a recording
  std::vector<int> order{};  ///< which frame shows each pattern; as they come where empty
  std::shared_ptr<const RecordingReader> recording{};  ///< opened, where it is one
  std::optional<std::uint64_t> window{};  ///< of a recording, see window_at; else its first cycle
  std::optional<std::filesystem::path> scanner{};  ///< the scanner file, or the recording
  /// Of pictures in colour: the same under an even grey of the projector, see unmixed.
  std::optional<std::filesystem::path> white{};
  /// The scan folder of a second camera that saw the same projector at the same time.
  std::optional<std::filesystem::path> second_camera{};
};

/// Reads scan.yaml; relative paths are resolved against its folder. Throws Error, naming file and
/// key, for an unknown key, a missing one or a value out of range.
ScanFiles read_scan_files(const std::filesystem::path& file);

/// What the text of a scan.yaml says, as read_scan_files; `name` is what messages call it. `frames`
/// may be missing in it.
ScanFiles scan_files_from(const std::string& text, const std::string& name,
                          const std::filesystem::path& folder);

/// Throws Error where the frames of the strategy are not as they were taken, see Strategy::read_as.
void require_as_taken(const Strategy& strategy);

/// The text of the scan.yaml in that folder. `frames` is missing where there are none. Throws Error
/// as require_as_taken.
std::string scan_yaml_of(const ScanFiles& scan, const std::filesystem::path& folder);

/// Writes scan.yaml; frames and scanner are named relative to its folder.
void write_scan_files(const std::filesystem::path& file, const ScanFiles& scan);

/// What is said of a scan over what its folder or recording says.
struct ScanChanges {
  SequenceChanges sequence{};
  /// Which frame shows each pattern, counted from 0, as "2,0,1"; or what comes first, as
  /// "code,sinusoids". Empty: as it was.
  std::string order{};
  /// The recording, where it is opened already, as for another of its windows.
  std::shared_ptr<const RecordingReader> recording{};
  std::optional<std::uint64_t> window{};
  std::optional<int> bits{};
  std::optional<std::filesystem::path> scanner{};
};

/// Throws Error where neither says what the frames show, for bits that no camera has and for an
/// order that is none.
void amend(ScanFiles& files, const ScanChanges& changes);

/// The scan in a folder, as its scan.yaml says it or the names of its pictures do, or in a
/// recording; with those changes. Throws Error where there is neither, and as amend.
ScanFiles scan_files_in(const std::filesystem::path& path, const ScanChanges& changes = {});

/// Whether name `a` comes before `b` as a person sorts them, numbers counted: board2 before
/// board10.
bool before_in_order(const std::string& a, const std::string& b);

/// Whether its name begins with a dot, as of what desktops leave in folders: .DS_Store,
/// ._frame.png.
bool is_hidden(const std::filesystem::path& path);

/// The pictures in a folder, in the order of their names with numbers counted: frame_2 before
/// frame_10; hidden ones are none. Throws Error when there is no such folder or no picture in it.
std::vector<std::filesystem::path> images_in_folder(const std::filesystem::path& folder);

}  // namespace slipstream
