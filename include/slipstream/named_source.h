#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "slipstream/camera.h"
#include "slipstream/sequence.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"

namespace slipstream {

/// A request to open a frame source.
struct SourceRequest {
  std::string source = "virtual";  ///< "SCHEME" or "SCHEME:WHAT"
  std::optional<double> rate{};    ///< Hz; 0: as fast as possible; nullopt: the source's own
  bool loop = false;               ///< restarts a recording at its end
  int scans = 1;                   ///< patterns per cycle
  bool marker = false;             ///< a dark frame ends each cycle; overrides the source
  SequenceChanges sequence{};      ///< override the source's own sequence
  std::optional<std::filesystem::path> scanner{};  ///< scanner file; overrides the source's own
  std::optional<VirtualWorld> world{};             ///< required by `virtual`
  CameraSettings camera{};                         ///< for `aravis` and `v4l2`
  /// Delivers colour pictures whole, with their channels side by side.
  bool as_taken = false;
  /// Called before `virtual` begins to render.
  std::function<void()> before_rendering = [] {};
  /// Called while `virtual` renders, from another thread, with the share that is rendered; may
  /// outlive the request, not the source.
  std::function<void(double)> while_rendering{};
  /// First rest of bodies that move in the virtual world. With `none` all frames are rendered at
  /// the start.
  FirstRest first_rest = FirstRest::none;

  /// Settings shared by flags and keywords.
  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit({"rate", "rate", "frames per second; 0: as fast as possible; default: the source's own"},
          self.rate);
    visit({"loop", "loop", "restart a recording at its end"}, self.loop);
  }
};

/// An opened source and its sequence and scanner, if known.
struct NamedSource {
  std::unique_ptr<FrameSource> frames{};
  Sequence sequence{};
  std::optional<Scanner> scanner{};
  std::string scanner_name{};  ///< name used in messages
  std::string warning{};       ///< status text; empty if all is well
  bool in_colour = false;      ///< frames are raw colour channels: see RecordingHeader
  FrameSet white{};            ///< white picture of colour scans: see RecordingHeader
  Image<Colour> colour{};      ///< of a replayed scan folder: see Scan
};

/// Unmixes colour channels for an engine, using the known crosstalk and the white picture.
std::unique_ptr<FrameSource> colours_apart(std::unique_ptr<FrameSource> channels,
                                           const NamedSource& opened);

/// The known sources: "virtual, replay:PATH, aravis:NAME, v4l2:NUMBER".
std::string source_forms();

/// "replay" of "replay:scan.slip".
std::string scheme_of(const std::string& source);

/// Throws Error for an unknown source, for one that does not fit the request, and for colour
/// pictures if the number of patterns is not a multiple of three; WorldError if it does not answer.
NamedSource open_source(const SourceRequest& request);

}  // namespace slipstream
