#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/process.h"
#include "slipstream/base/error.h"
#include "slipstream/base/image.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/plot.h"
#include "slipstream/spatial/spatial_unwrapping.h"

namespace slipstream::app {
namespace {

struct UnwrapFlags {
  std::string input, output, method = "flow";
  std::optional<std::string> quality, mask, coarse, regions, preview;
  std::vector<double> anchor;  ///< row, column, phase
};

void leave_out(Image<double>& phase, const Image<double>& mask) {
  if (mask.size() != phase.size()) {
    throw Error(fmt::format("the mask is {}, but the phase {}", text_of(mask.size()),
                            text_of(phase.size())));
  }
  for (std::size_t i = 0; i < phase.pixel_count(); ++i) {
    const double in = mask.begin()[i];
    if (in == 0 || std::isnan(in)) phase.begin()[i] = std::numeric_limits<double>::quiet_NaN();
  }
}

void anchor(const UnwrapFlags& flags, UnwrappedPhase<double>& unwrapped) {
  if (!flags.anchor.empty()) {
    const double row = flags.anchor[0], column = flags.anchor[1];
    constexpr double largest = 1e6;
    if (std::rint(row) != row || std::rint(column) != column || std::abs(row) > largest ||
        std::abs(column) > largest) {
      throw Error("--anchor takes a row and a column, whole numbers, and a phase");
    }
    anchor_at(unwrapped, static_cast<int>(column), static_cast<int>(row), flags.anchor[2]);
  }
  if (flags.coarse) anchor_by(unwrapped, read_map(*flags.coarse));
}

void tell(const UnwrappedPhase<double>& unwrapped, Output& output) {
  std::size_t pixels = 0, anchored = 0;
  for (const PhaseRegion& region : unwrapped.regions) {
    pixels += region.pixels;
    anchored += region.anchored ? 1 : 0;
    output.list("regions").push_back({{"pixels", region.pixels}, {"anchored", region.anchored}});
  }
  output.document["pixels"] = pixels;
  const std::size_t count = unwrapped.regions.size();
  output.say("{} pixels in {} region{}{}; {} anchored", pixels, count, count == 1 ? "" : "s",
             count > 1 ? fmt::format(", the largest of {}", unwrapped.regions.front().pixels) : "",
             anchored);
}

void unwrap(const UnwrapFlags& flags, Output& output) {
  require_map_ending(flags.output);
  if (flags.regions) require_map_ending(*flags.regions);
  if (flags.preview) require_ending(*flags.preview, "preview", {".png"});
  Image<double> phase = read_map(flags.input);
  if (flags.mask) leave_out(phase, read_levels(*flags.mask));
  Image<float> quality;
  if (flags.quality) quality = converted<float>(read_levels(*flags.quality));
  Stopwatch watch;
  UnwrappedPhase<double> unwrapped = unwrap_in_space(phase, quality, flags.method);
  output.document["seconds"] = watch.lap();
  anchor(flags, unwrapped);
  output.document["method"] = flags.method;
  tell(unwrapped, output);
  write_map(flags.output, unwrapped.phase);
  if (flags.regions) write_map(*flags.regions, converted<float>(unwrapped.region));
  if (flags.preview) write_map_preview(*flags.preview, unwrapped.phase, "phase, rad");
}

std::string methods() {
  std::string text;
  for (const SpatialUnwrapping& method : spatial_unwrappings()) {
    text += fmt::format("\n  {:14} {}", method.name, method.text);
  }
  return text;
}

}  // namespace

void add_unwrap(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, unwrap, "unwrap",
                  "unwraps a phase map of any instrument by its neighbouring pixels");
  command.add_file("wrapped", flags.input, "phase in rad, NaN where there is none: .tiff or .npy")
      ->required();
  command.add_output("-o,--output", flags.output, "the unwrapped phase: .tiff or .npy")->required();
  command.add("--method", flags.method, "how: see below");
  command.add_file("--quality", flags.quality, "how sure each pixel is, as the modulation");
  command.add_file("--mask", flags.mask, "0 where pixels are left out");
  CLI::Option* const anchored =
      command
          .add("--anchor", flags.anchor, "a row, a column and the phase there, rad, that is known")
          ->expected(3);
  command
      .add_file("--coarse", flags.coarse, "an absolute phase that is right within half a period")
      ->excludes(anchored);
  command.add_output("--regions", flags.regions,
                     "the number of the region of each pixel: .tiff or .npy");
  command.add_output("--preview", flags.preview, "the phase in colours: .png");
  command.app.footer(
      "Methods:" + methods() +
      "\nExamples:\n  slipstream unwrap wrapped.tiff -o phase.tiff --preview phase.png\n"
      "  slipstream unwrap wrapped.npy -o phase.npy --method quality --anchor 240 320 12.5\n"
      "Regions that pixels without a phase keep apart are unwrapped each by itself. A step of half "
      "a period or more between neighbours cannot be known from one map.");
}

}  // namespace slipstream::app
