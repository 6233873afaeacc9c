#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/progress.h"
#include "app/scan_flags.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct PatternsFlags {
  std::string folder;
  ScanFlags scan;
  int bits = 8;
};

Image<std::uint8_t> as_8_bits(const Image<std::uint16_t>& picture) {
  Image<std::uint8_t> narrow(picture.size());
  std::copy(picture.begin(), picture.end(), narrow.begin());
  return narrow;
}

void write_patterns(const PatternsFlags& flags, Output& output) {
  ScanDescription scan;
  scan.strategy = strategy_from(flags.scan, DualFrequency{});
  scan.axis = axis_from(flags.scan, Axis::x);
  scan.light = light_from(flags.scan, {});
  scan.projector = projector_from(flags.scan, {1920, 1080});
  require_resolved(scan.strategy, length_along(scan.axis, scan.projector));
  const PatternSet patterns = pattern_set(scan.strategy, scan.axis, scan.light);

  const fs::path folder = flags.folder;
  Progress progress("patterns", patterns.count);
  for (int n = 0; n < patterns.count; ++n) {
    const Image<std::uint16_t> picture = render_pattern(patterns, n, scan.projector, flags.bits);
    if (n == 0) make_folder(folder);
    const fs::path file = folder / fmt::format("pattern_{:02}.png", n);
    flags.bits == 8 ? write_image(file, as_8_bits(picture)) : write_image(file, picture);
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
  command->add_option("--bits", flags->bits, "grey levels of the projector: 8 to 16 bits")
      ->capture_default_str();
  add_shared_flags(*command, shared);
  command->footer(
      "Example:\n  slipstream patterns patterns --strategy dual-frequency --steps 3 --high 16 "
      "--low 1 --axis x --projector 1824x1140");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { write_patterns(*flags, output); }; });
}

}  // namespace slipstream::app
