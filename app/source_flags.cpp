#include "app/source_flags.h"

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream::app {

SourceRequest request_from(const SourceFlags& flags, bool marker) {
  SourceRequest request{.source = flags.source,
                        .rate = flags.rate,
                        .loop = flags.loop,
                        .marker = marker,
                        .sequence = changes_from(flags.scan)};
  if (flags.scanner) request.scanner = *flags.scanner;
  const std::string scheme = scheme_of(flags.source);
  if ((scheme == "virtual" || scheme == "replay") && flags.camera.pixel_format == "RGB8") {
    throw Error(fmt::format("--pixel-format RGB8: is of a camera, and {} is none; leave it out",
                            flags.source));
  }
  if (scheme == "virtual") {
    VirtualFlags world = flags.virtual_scanner;
    world.scanner = flags.scanner;
    request.world = world_from(world);
  } else if (scheme != "replay") {
    request.camera = camera_settings(flags.camera);
  }
  return request;
}

}  // namespace slipstream::app
