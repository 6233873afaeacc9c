#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/commands.h"
#include "app/scan_input.h"
#include "slipstream/io/cloud_file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/reconstruct/reconstructor.h"
#include "slipstream/view/snapshot.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct ViewFlags {
  std::string path;
  ScanInputFlags input;
  std::string snapshot;
  std::string size = "1280x800";
  std::string colour = "reflectivity";
};

Image<float> narrowed(const Image<double>& image) {
  Image<float> narrow(image.size());
  std::copy(image.begin(), image.end(), narrow.begin());
  return narrow;
}

FusedCloud as_displayed(const Cloud& cloud) {
  FusedCloud single;
  single.x = narrowed(cloud.x);
  single.y = narrowed(cloud.y);
  single.z = narrowed(cloud.z);
  single.intensity = cloud.intensity;
  single.validity = cloud.validity;
  return single;
}

void view_path(const ViewFlags& flags, Output& output) {
  view::ViewSettings settings{.colour = view::point_colour_named(flags.colour)};
  const Size size = size_from(flags.size, "--size");
  FusedCloud cloud;
  std::optional<Image<float>> modulation;
  view::SceneLight light;
  if (fs::is_directory(flags.path)) {
    const ScanDescription scan = describe(flags.path, flags.input);
    const LoadedFrames loaded = read_frames(scan.frames, scan.bits);
    const GammaChoice gamma = choose_gamma(flags.input.gamma, scan, loaded.frames);
    ReconstructSettings asked;
    asked.backend = Backend::fused;
    const ReconstructSettings reconstruct_settings =
        settings_for(asked, scan, gamma, photometry_for(scan, flags.input));
    const Reconstruction result =
        Reconstructor(scanner_for(scan, loaded.frames.size()), scan.strategy, scan.axis,
                      reconstruct_settings)(loaded.frames);
    cloud = as_displayed(result.cloud);
    modulation = narrowed(result.decoded.modulation);
    light = {reconstruct_settings.cue.light, reconstruct_settings.cue.ambient};
  } else {
    cloud = as_displayed(read_cloud(flags.path));
  }
  write_image(flags.snapshot,
              view::render_snapshot({cloud.x, cloud.y, cloud.z, cloud.intensity},
                                    modulation ? &*modulation : nullptr, settings, light, size));
  output.say("drew {}: {}", flags.path, flags.snapshot);
  output.document = {{"snapshot", flags.snapshot}};
}

}  // namespace

void add_view(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command = program.add_subcommand("view", "draw a cloud or a scan folder as a picture");
  const auto flags = std::make_shared<ViewFlags>();
  command->add_option("path", flags->path, "a PLY file or a scan folder")->required();
  command
      ->add_option("--snapshot", flags->snapshot,
                   "draw it without a window into this file: .png, .tiff or .bmp")
      ->required();
  command->add_option("--size", flags->size, "of the picture, pixels")->capture_default_str();
  command
      ->add_option("--colour", flags->colour,
                   fmt::format("of the points: {}", fmt::join(view::point_colour_names(), ", ")))
      ->capture_default_str();
  add_scan_input_flags(*command, flags->input);
  add_shared_flags(*command, shared);
  command->footer(
      "Examples:\n  slipstream view cloud.ply --snapshot cloud.png --colour depth\n  slipstream "
      "view scan --snapshot scan.png --size 1920x1080");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { view_path(*flags, output); }; });
}

}  // namespace slipstream::app
