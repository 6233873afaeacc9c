#include "app/view_flags.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/scan_flags.h"
#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/view/view_settings.h"

namespace slipstream::app {
namespace {

void require_picture_ending(const std::string& path) {
  if (path.empty()) return;
  const std::string extension = lower_case_extension(path);
  if (extension != ".png" && extension != ".tiff" && extension != ".tif" && extension != ".bmp") {
    throw Error(fmt::format("{}: no picture in colour has the ending '{}'; use .png, .tiff or .bmp",
                            path, extension));
  }
}

}  // namespace

void add_view_flags(CLI::App& subcommand, ViewFlags& flags) {
  const std::string group = "What is drawn";
  subcommand
      .add_option("--snapshot", flags.snapshot,
                  "the cloud as a picture, drawn without a window: .png, .tiff or .bmp")
      ->group(group);
  subcommand
      .add_option("--screenshot", flags.screenshot,
                  "likewise with the panel and the camera's pictures beside it")
      ->group(group);
  subcommand.add_option("--size", flags.size, "of window and pictures, pixels")
      ->capture_default_str()
      ->group(group);
  subcommand
      .add_option("--colour", flags.colour,
                  fmt::format("of the points: {}", fmt::join(view::point_colour_names(), ", ")))
      ->capture_default_str()
      ->group(group);
  subcommand
      .add_option("--save-to", flags.save_to,
                  "where the viewer's Save makes a folder for each scan")
      ->capture_default_str()
      ->group(group);
}

void require_good(const ViewFlags& flags) {
  require_picture_ending(flags.snapshot);
  require_picture_ending(flags.screenshot);
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
