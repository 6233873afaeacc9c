#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/image/size.h"
#include "slipstream/pattern/axis.h"
#include "slipstream/pattern/pattern_set.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream {

/// What scan.yaml says of the pictures in its folder.
struct ScanDescription {
  Strategy strategy;
  Axis axis = Axis::x;
  PatternLight light;                            ///< of the patterns
  Size projector;                                ///< pixels; empty where not said
  int bits = 0;                                  ///< of the camera; 0 where not said
  std::vector<std::filesystem::path> frames;     ///< in pattern order
  std::optional<std::filesystem::path> scanner;  ///< the scanner file
  /// The scan folder of a second camera that saw the same projector at the same time.
  std::optional<std::filesystem::path> second_camera;
};

/// Reads scan.yaml; relative paths are resolved against its folder. Throws Error, naming file and
/// key, for an unknown key, a missing one or a value out of range.
ScanDescription read_scan_description(const std::filesystem::path& file);

/// What the text of a scan.yaml says, as read_scan_description; `name` is what messages call it.
/// `frames` may be missing in it.
ScanDescription scan_description_from(const std::string& text, const std::string& name,
                                      const std::filesystem::path& folder);

/// The text of the scan.yaml in that folder. `frames` is missing where there are none.
std::string scan_description_text(const ScanDescription& scan, const std::filesystem::path& folder);

/// Writes scan.yaml; frames and scanner are named relative to its folder.
void write_scan_description(const std::filesystem::path& file, const ScanDescription& scan);

/// Whether name `a` comes before `b` as a person sorts them, numbers counted: board2 before
/// board10.
bool before_in_order(const std::string& a, const std::string& b);

/// The pictures in a folder, in the order of their names with numbers counted: frame_2 before
/// frame_10. Throws Error when there is no such folder or no picture in it.
std::vector<std::filesystem::path> images_in_folder(const std::filesystem::path& folder);

}  // namespace slipstream
