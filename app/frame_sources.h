#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/camera_flags.h"
#include "app/scan_flags.h"
#include "app/virtual_flags.h"
#include "slipstream/capture/frame_source.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/live/live_settings.h"

namespace slipstream::app {

/// What a source of frames is opened by.
struct SourceRequest {
  std::string source = "virtual";  ///< "SCHEME" or "SCHEME:WHAT"
  std::optional<double> rate;      ///< Hz
  bool loop = false;               ///< a recording begins again at its end
  PatternIndexing indexing = PatternIndexing::told;
  ScanFlags scan;
  std::optional<std::string> scanner;  ///< file
  VirtualFlags virtual_scanner;        ///< of `virtual`; its scanner is that above
  CameraFlags camera;                  ///< of `aravis` and `v4l2`
};

/// A source, and what is known of what it sees.
struct OpenedSource {
  std::unique_ptr<FrameSource> frames;
  ScanDescription scan;      ///< strategy, axis, light and projector
  std::string scanner;       ///< the text of a scanner file; empty where there is none
  std::string scanner_name;  ///< what a message calls it
  std::string warning;       ///< for people; empty where all is well
};

/// What can be asked for: "virtual, replay:PATH, aravis:NAME, v4l2:NUMBER".
std::string source_forms();

/// Throws Error for a source that is not known or does not fit the request, WorldError for one that
/// does not answer.
OpenedSource open_source(const SourceRequest& request);

/// Throws Error where `file`, which is to be written, is what the source replays.
void require_not_replayed(const SourceRequest& request, const std::string& file);

}  // namespace slipstream::app
