#include "app/view_flags.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/flag_group.h"
#include "app/scan_flags.h"
#include "slipstream/io/image_file.h"
#include "slipstream/view/view_settings.h"

namespace slipstream::app {

void add_view_flags(CLI::App& subcommand, ViewFlags& flags) {
  const FlagGroup group{subcommand, "What is drawn"};
  group.add_output("--snapshot", flags.snapshot,
                   "the cloud as a picture, drawn without a window: .png, .tiff or .bmp");
  group.add_output("--screenshot", flags.screenshot,
                   "likewise with the panel and the camera's pictures beside it");
  group.add("--size", flags.size, "of window and pictures, pixels");
  group.add("--colour", flags.colour,
            fmt::format("of the points: {}", fmt::join(view::point_colour_names(), ", ")));
  group.add("--save-to", flags.save_to, "where the viewer's Save makes a folder for each scan");
}

void require_good(const ViewFlags& flags) {
  for (const std::string& path : {flags.snapshot, flags.screenshot}) {
    if (!path.empty()) require_colour_ending(path);
  }
  static_cast<void>(size_from(flags));
  static_cast<void>(view_settings_from(flags));
}

Size size_from(const ViewFlags& flags) {
  return size_from(flags.size, "--size");
}

view::ViewSettings view_settings_from(const ViewFlags& flags) {
  view::ViewSettings settings;
  settings.colour = view::point_colour_named(flags.colour);
  return settings;
}

}  // namespace slipstream::app
