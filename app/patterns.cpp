#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/progress.h"
#include "app/scan_flags.h"
#include "slipstream/error/error.h"
#include "slipstream/gamma/precompensation.h"
#include "slipstream/io/file.h"
#include "slipstream/io/folder_sink.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/response_file.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/pattern/pattern_in_8_bits.h"
#include "slipstream/strategy/multiplexing_design.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct PatternsFlags {
  std::string folder;
  ScanFlags scan;
  int bits = 8;
  std::optional<std::string> precompensate;
  int uniform = 0;
};

/// A gamma, or the response that a scanner file holds.
Response response_from(const std::string& text) {
  double gamma = 0;
  const auto [rest, failure] = std::from_chars(text.data(), text.data() + text.size(), gamma);
  if (failure == std::errc() && rest == text.data() + text.size()) {
    require_gamma(gamma, "--precompensate");
    return PowerLaw{gamma};
  }
  const std::optional<Response> response = read_response(text);
  if (!response) {
    throw Error(fmt::format("{}: no gamma in it; slipstream calibrate gamma puts it there", text));
  }
  return *response;
}

/// Pictures of one grey level each, from 0 to 255, for `calibrate gamma --uniform`.
void write_uniform(const PatternsFlags& flags, Output& output) {
  if (flags.uniform < 4 || flags.uniform > 256) {
    throw Error(fmt::format("--uniform {} is out of range; 4 to 256 pictures", flags.uniform));
  }
  const Size projector = projector_from(flags.scan, {1920, 1080});
  const fs::path folder = flags.folder;
  make_folder(folder);
  for (int i = 0; i < flags.uniform; ++i) {
    const auto level = static_cast<std::uint8_t>(std::lround(255.0 * i / (flags.uniform - 1)));
    const fs::path file = folder / fmt::format("level_{:03}.png", level);
    write_image(file, Image<std::uint8_t>(projector, level));
    output.document["patterns"].push_back(file.string());
  }
  output.say(
      "wrote {} uniform patterns to {}; take a picture of each under the same name, and run: "
      "slipstream calibrate gamma --uniform THAT_FOLDER",
      flags.uniform, folder.string());
}

/// Patterns of pcmp that can be shown but whose cue is too weak for their periods.
void warn_if_unwise(const ScanDescription& scan, Output& output) {
  constexpr double alpha = 0.5, least_success = 0.85;
  const auto* pcmp = std::get_if<PhaseChannelMultiplexing>(&scan.strategy);
  if (pcmp == nullptr) return;
  const CueSettings usual{};
  const double success =
      predicted_unwrapping(*pcmp, scan.light, alpha, usual.ambient, usual.noise_variance);
  if (success >= least_success) return;
  output.warn(fmt::format(
      "at a reflectivity of {} and sigma_w^2 of {} only {:.0f} % of the pixels would be unwrapped "
      "rightly each by itself; fewer periods or a smaller --share are wiser, see slipstream design",
      alpha, usual.noise_variance, 100 * success));
}

void write_patterns(const PatternsFlags& flags, Output& output) {
  ScanDescription scan;
  scan.strategy = strategy_from(flags.scan, DualFrequency{});
  scan.axis = axis_from(flags.scan, Axis::x);
  scan.light = light_from(flags.scan, {});
  scan.projector = projector_from(flags.scan, {1920, 1080});
  require_resolved(scan.strategy, length_along(scan.axis, scan.projector));
  warn_if_unwise(scan, output);
  PatternSet patterns = pattern_set(scan.strategy, scan.axis, scan.light);
  if (flags.precompensate) patterns = precompensated(patterns, response_from(*flags.precompensate));

  const fs::path folder = flags.folder;
  Progress progress("patterns", patterns.count);
  for (int n = 0; n < patterns.count; ++n) {
    const Image<std::uint16_t> picture = render_pattern(patterns, n, scan.projector, flags.bits);
    if (n == 0) make_folder(folder);
    const fs::path file = pattern_file(folder, static_cast<std::size_t>(n));
    flags.bits == 8 ? write_image(file, in_8_bits(picture)) : write_image(file, picture);
    scan.frames.push_back(file);
    progress.advance();
  }
  write_scan_description(folder / "scan.yaml", scan);

  output.say("wrote {} patterns of {} for a projector of {} to {}", patterns.count,
             name_of(scan.strategy), text_of(scan.projector), folder.string());
  output.say(
      "project them in that order, put the camera's pictures beside {} under the same names,",
      (folder / "scan.yaml").filename().string());
  output.say("and run: slipstream reconstruct THAT_FOLDER --scanner SCANNER.yaml -o cloud.ply");
  for (const fs::path& frame : scan.frames) output.document["patterns"].push_back(frame.string());
  output.document["scan"] = (folder / "scan.yaml").string();
}

}  // namespace

void add_patterns(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* command =
      program.add_subcommand("patterns", "write a strategy's patterns as images for any projector");
  const auto flags = std::make_shared<PatternsFlags>();
  command->add_option("folder", flags->folder, "where the pictures and scan.yaml go")->required();
  add_scan_flags(*command, flags->scan);
  CLI::Option* const bits =
      command->add_option("--bits", flags->bits, "grey levels of the projector: 8 to 16 bits")
          ->capture_default_str();
  CLI::Option* const precompensate = command->add_option(
      "--precompensate", flags->precompensate,
      "a gamma, or a scanner file that holds one: its inverse is applied to the "
      "pictures, so that the projector's light is as meant");
  command
      ->add_option("--uniform", flags->uniform,
                   "so many uniform pictures from black to white instead, to measure gamma with")
      ->excludes(bits)
      ->excludes(precompensate);
  add_shared_flags(*command, shared);
  command->footer(
      "Example:\n  slipstream patterns patterns --strategy dual-frequency --steps 3 --high 16 "
      "--low 1 --axis x --projector 1824x1140");
  command->callback([flags, &chosen] {
    chosen = [flags](Output& output) {
      flags->uniform != 0 ? write_uniform(*flags, output) : write_patterns(*flags, output);
    };
  });
}

}  // namespace slipstream::app
