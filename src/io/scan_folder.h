#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "slipstream/recording.h"
#include "slipstream/scan_files.h"

namespace slipstream {

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

/// Where the scan of a further camera is put beside the first one's files: "second", "camera-3" and
/// so on.
std::string folder_of_camera(std::size_t number);

/// The order of a sequence's frames from text: "2,0,1", "0-17,36-49", "sinusoids,code" or
/// "code,sinusoids". Throws Error for any other text.
std::vector<int> order_from(const std::string& text, const Sequence& sequence);

/// The first numbers of an order as text, for messages.
std::string text_of_order(const std::vector<int>& order);

/// Applies the changes. Throws Error if the sequence remains unknown, for unsupported bits, a
/// missing window of pictures and an invalid order.
void amend(ScanFiles& files, const ScanChanges& changes);

/// Number of windows in that many pictures, each a cycle with its motion frames.
std::uint64_t window_count(std::size_t pictures, const Sequence& sequence);

/// The description of a recording's scan; opens it unless `recording` is set.
ScanFiles recorded_files(const std::filesystem::path& path,
                         std::shared_ptr<const RecordingReader> recording);

}  // namespace slipstream
