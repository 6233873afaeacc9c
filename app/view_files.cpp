#include "app/view_files.h"

#include "slipstream/base/error.h"
#include "slipstream/io/image_file.h"
#include "slipstream/view/view_settings.h"

namespace slipstream::app {
namespace {

void draw(const view::ViewSource& source, const ViewFlags& flags, view::Surround surround,
          const char* name, const std::string& path, Output& output) {
  if (path.empty()) return;
  if (!source.newest()) {
    throw WorldError(fmt::format("{}: no cloud came that could be drawn", path));
  }
  write_picture(name, path,
                view::render_screen(source, view_settings_from(flags), size_from(flags), surround),
                output);
}

}  // namespace

void write_picture(const char* name, const std::string& path, const Image<Colour>& picture,
                   Output& output) {
  write_image(path, picture);
  output.say("{}: {}", name, path);
  output.object("files")[name] = path;
}

void write_snapshot(const view::ViewSource& source, const ViewFlags& flags, Output& output) {
  draw(source, flags, view::Surround::nothing, "snapshot", flags.snapshot, output);
}

void write_screenshot(const view::ViewSource& source, const ViewFlags& flags, Output& output) {
  draw(source, flags, view::Surround::panel, "screenshot", flags.screenshot, output);
}

}  // namespace slipstream::app
