#include <filesystem>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/output.h"
#include "app/scan_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/codes/design.h"
#include "slipstream/io/pattern_pictures.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/response/correction.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct PatternsFlags {
  std::string folder;
  SequenceChanges scan;
  int bits = 8;
  std::optional<std::string> precompensate;
  int uniform = 0;
  std::string sheet;
  bool in_colour = false;
};

constexpr Size usual_projector{1920, 1080};

/// Pictures of one grey level each, from 0 to 255, for `calibrate gamma --uniform`.
void write_uniform(const PatternsFlags& flags, Output& output) {
  if (flags.uniform < 4 || flags.uniform > 256) {
    throw Error(fmt::format("--uniform {} is out of range; 4 to 256 pictures", flags.uniform));
  }
  const Size projector = flags.scan.projector.value_or(usual_projector);
  for (const fs::path& file : write_uniform_pictures(flags.folder, projector, flags.uniform)) {
    output.list("patterns").push_back(file.string());
  }
  output.say(
      "wrote {} uniform patterns to {}; take a picture of each under the same name, and run: "
      "slipstream calibrate gamma --uniform THAT_FOLDER",
      flags.uniform, flags.folder);
}

void write_patterns(const PatternsFlags& flags, Output& output) {
  const Sequence sequence = default_sequence(usual_projector, flags.scan);
  if (const std::string doubt = doubt_about(sequence); !doubt.empty()) output.warn(doubt);
  PatternSet patterns = pattern_set(sequence);
  if (flags.precompensate) {
    patterns = precompensated(patterns, response_named(*flags.precompensate, "--precompensate"));
  }
  const fs::path folder = flags.folder;
  if (!flags.sheet.empty()) {
    write_pattern_sheet(flags.sheet, patterns, length_along(sequence.axis, sequence.projector));
    output.document["sheet"] = flags.sheet;
  }
  Progress progress("patterns", flags.in_colour ? patterns.count / 3 : patterns.count);
  const auto advance = [&] { progress.advance(); };
  const std::vector<fs::path> pictures =
      flags.in_colour ? write_colour_patterns(folder, patterns, sequence, advance)
                      : slipstream::write_patterns(folder, patterns, sequence, flags.bits, advance);
  for (const fs::path& picture : pictures) output.list("patterns").push_back(picture.string());
  output.document["scan"] = (folder / "scan.yaml").string();
  output.say("wrote {} patterns of {} for a projector of {} to {}", pictures.size(),
             sequence.strategy.name(), text_of(sequence.projector), folder.string());
  output.say(
      "project them in that order, put the camera's pictures beside scan.yaml under the same "
      "names,");
  output.say("and run: slipstream reconstruct THAT_FOLDER --scanner SCANNER.yaml -o cloud.ply");
}

void write_asked(const PatternsFlags& flags, Output& output) {
  flags.uniform != 0 ? write_uniform(flags, output) : write_patterns(flags, output);
}

}  // namespace

void add_patterns(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, write_asked, "patterns",
                  "write a strategy's patterns as images for any projector");
  command.add("folder", flags.folder, "where the pictures and scan.yaml go")->required();
  add_pattern_flags(command.app, flags.scan);
  add_marker_flag(command.app, flags.scan);
  command.app.get_option("--projector")->default_str(text_of(usual_projector));
  CLI::Option* const bits = command.add("--pattern-bits", flags.bits,
                                        "of the pictures, as the projector takes them: 8 to 16");
  CLI::Option* const precompensate =
      command.add("--precompensate", flags.precompensate,
                  "a gamma, or a scanner file that holds one: its inverse is applied to the "
                  "pictures, so that the projector's light is as meant");
  for (CLI::Option* const grey : {bits, precompensate}) {
    grey->excludes(command.app.get_option("--binary"));
  }
  CLI::Option* const in_colour =
      command.add("--colour", flags.in_colour,
                  "three patterns to a picture, its red, green and blue; and the pictures for "
                  "calibrate colour");
  in_colour->excludes(bits)->excludes(command.app.get_option("--binary"));
  CLI::Option* const sheet = command.add("--sheet", flags.sheet,
                                         "also one picture of all patterns, a strip of each: .png");
  command
      .add("--uniform", flags.uniform,
           "so many uniform pictures from black to white instead, to measure gamma with")
      ->default_str("")
      ->excludes(bits)
      ->excludes(command.app.get_option("--binary"))
      ->excludes(precompensate)
      ->excludes(sheet);
  command.app.footer(
      "Example:\n  slipstream patterns patterns --strategy dual-frequency --steps 3 --high 16 "
      "--low 1 --axis x --projector 1824x1140");
}

}  // namespace slipstream::app
