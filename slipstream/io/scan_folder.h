#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/strategy/sequence.h"

namespace slipstream {

/// What scan.yaml says of a scan, and the files that it is in.
struct ScanFiles {
  Sequence sequence{};
  int bits = 0;                                    ///< of the camera; 0 where not said
  std::vector<std::filesystem::path> frames{};     ///< in pattern order
  std::optional<std::filesystem::path> scanner{};  ///< the scanner file
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

/// The text of the scan.yaml in that folder. `frames` is missing where there are none.
std::string scan_yaml_of(const ScanFiles& scan, const std::filesystem::path& folder);

/// Writes scan.yaml; frames and scanner are named relative to its folder.
void write_scan_files(const std::filesystem::path& file, const ScanFiles& scan);

/// What scan.yaml in the folder says; where there is none, the folder's pictures and nothing of
/// what they are. Throws Error where there is no such folder.
ScanFiles scan_files_in(const std::filesystem::path& folder);

/// Whether name `a` comes before `b` as a person sorts them, numbers counted: board2 before
/// board10.
bool before_in_order(const std::string& a, const std::string& b);

/// The pictures in a folder, in the order of their names with numbers counted: frame_2 before
/// frame_10. Throws Error when there is no such folder or no picture in it.
std::vector<std::filesystem::path> images_in_folder(const std::filesystem::path& folder);

}  // namespace slipstream
