#pragma once

#include <filesystem>

#include "slipstream/codes/sequence.h"
#include "slipstream/devices/camera.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// What a source of frames is opened by.
struct SourceRequest {
  std::string source = "virtual";  ///< "SCHEME" or "SCHEME:WHAT"
  std::optional<double> rate{};    ///< Hz; 0: as fast as it goes; none: the source's own
  bool loop = false;               ///< a recording begins again at its end
  int scans = 1;                   ///< of the sequence that a cycle shows, one after another
  bool marker = false;             ///< a dark frame ends each cycle, whatever the source says
  SequenceChanges sequence{};      ///< over what the source says that it sees
  std::optional<std::filesystem::path> scanner{};  ///< file, over the source's own
  std::optional<VirtualWorld> world{};             ///< of `virtual`, which needs one
  CameraSettings camera{};                         ///< of `aravis` and `v4l2`
  /// Pictures in colour are given as their channels, and are not taken apart.
  bool as_taken = false;
};

/// A source, and what is known of what it sees.
struct NamedSource {
  std::unique_ptr<FrameSource> frames;
  Sequence sequence{};
  std::optional<Scanner> scanner{};
  std::string scanner_name{};  ///< what a message calls it
  std::string warning{};       ///< for people; empty where all is well
  bool in_colour = false;      ///< frames are channels as they were taken: see RecordingHeader
  FrameSet white{};            ///< of pictures in colour, as RecordingHeader has it
};

/// Colour channels unmixed for an engine, by the known mixture and the white picture.
std::unique_ptr<FrameSource> colours_apart(std::unique_ptr<FrameSource> channels,
                                           const NamedSource& opened);

/// What can be asked for: "virtual, replay:PATH, aravis:NAME, v4l2:NUMBER".
std::string source_forms();

/// "replay" of "replay:scan.slip".
std::string scheme_of(const std::string& source);

/// Throws Error for a source that is not known or does not fit the request, and for pictures in
/// colour under patterns that are not three to each; WorldError for one that does not answer.
NamedSource open_source(const SourceRequest& request);

}  // namespace slipstream
