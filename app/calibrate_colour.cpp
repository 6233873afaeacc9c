#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/calibration_files.h"
#include "app/commands.h"
#include "slipstream/base/error.h"
#include "slipstream/codes/primaries.h"
#include "slipstream/frames/colour_channels.h"
#include "slipstream/io/image_file.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct CalibrateColourFlags {
  std::string folder;
  CalibrationFiles files;
};

/// The picture of that name, whatever its ending.
fs::path picture_named(const fs::path& folder, const std::string& name) {
  for (const fs::path& picture : images_in_folder(folder)) {
    if (picture.stem() == name) return picture;
  }
  throw Error(fmt::format("{}: no picture {}; wanted are {} of a white surface", folder.string(),
                          name, fmt::join(primary_names, ", ")));
}

void calibrate_colour(const CalibrateColourFlags& flags, Output& output) {
  std::vector<fs::path> pictures(primary_names.size());
  std::transform(primary_names.begin(), primary_names.end(), pictures.begin(),
                 [&](const char* name) { return picture_named(flags.folder, name); });
  const ColourMixture mixture = measured_mixture(read_colour_frames(pictures));
  for (std::size_t c = 0; c < mixture.size(); ++c) {
    const auto& [red, green, blue, dark] = mixture[c];
    output.say("the camera's {} sees {:.3f} of red, {:.3f} of green, {:.3f} of blue; dark {:.1f}",
               primary_names[c + 1], red, green, blue, dark);
  }
  output.document["colour_mixture"] = mixture;
  write_calibration(flags.files, {.colour_mixture = mixture}, output);
}

}  // namespace

void add_calibrate_colour(CLI::App& calibrate, Command& chosen) {
  const auto [command, flags] =
      add_command(calibrate, chosen, calibrate_colour, "colour",
                  "what a camera's red, green and blue see of a projector's, from pictures of a "
                  "white surface");
  command
      .add_file("folder", flags.folder,
                "pictures named as what was shown: black, red, green, blue (patterns --colour)")
      ->required();
  add_calibration_files(command.app, flags.files);
  command.app.footer(
      "Example:\n  slipstream calibrate colour white --scanner scanner.yaml -o scanner.yaml");
}

}  // namespace slipstream::app
