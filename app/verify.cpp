#include <optional>
#include <string>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/output.h"
#include "app/scan_input.h"
#include "app/source_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/codes/registry.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/accuracy.h"

namespace slipstream::app {
namespace {

struct VerifyFlags {
  std::optional<std::string> artefacts, report, calibrated;
  bool rehearse = false;
  VirtualFlags devices;  ///< of a rehearsal: its world
  CloudInputFlags input;
};

void tell(const Accuracy& accuracy, std::optional<double> diagonal, Output& output) {
  for (const AccuracyFigure& figure : accuracy_figures(accuracy)) {
    output.document["figures_mm"][std::string(figure.key)] = figure.value;
    output.say("{}: {:.4f} mm{}", figure.what, figure.value,
               diagonal ? fmt::format(", {:.3f} per mille", 1000 * figure.value / *diagonal) : "");
  }
  for (const ShapeAccuracy& shape : accuracy.shapes) {
    nlohmann::json told{{"scan", shape.scan},
                        {"form_mm", shape.range},
                        {"form_95_mm", shape.range_95},
                        {"rms_mm", shape.rms},
                        {"points", shape.points}};
    if (shape.size) told["size_mm"] = *shape.size;
    if (shape.spacing) told["spacing_mm"] = *shape.spacing;
    if (shape.bending) told["planarity_mm"] = *shape.bending;
    output.list(shape.size ? "spheres" : "planes").push_back(std::move(told));
  }
}

/// A test, and in a line what it is of.
struct Test {
  Rehearsal rehearsal;
  std::string subject;
};

Test rehearsed(const VerifyFlags& flags) {
  VirtualFlags devices = flags.devices;
  devices.scene = "board";  // it makes way for the artefacts
  devices.scanner = flags.input.input.changes.scanner;
  const VirtualWorld world = world_from(devices);
  const Scanner calibrated =
      flags.calibrated ? read_scanner(*flags.calibrated) : as_calibrated(world);
  require_valid(flags.input.settings.clean);
  const Sequence sequence = sequence_for(flags.input.input.changes.sequence, world.scanner);
  return {rehearsal(world, sequence, calibrated, flags.input.settings),
          fmt::format("Rehearsed in the virtual world {}: {}", devices.world,
                      label_of(sequence.strategy))};
}

Test of_artefacts(const VerifyFlags& flags, Output& output) {
  Artefacts artefacts = read_artefacts(*flags.artefacts);
  return {
      {std::move(artefacts),
       [&](const std::string& scan) { return organised_cloud(scan, flags.input, output).cloud; }},
      "Artefacts of " + *flags.artefacts};
}

void verify_accuracy(const VerifyFlags& flags, Output& output) {
  if (flags.rehearse == flags.artefacts.has_value()) {
    throw Error("give the file of the artefacts, or --rehearse");
  }
  const auto [test, subject] = flags.rehearse ? rehearsed(flags) : of_artefacts(flags, output);
  const Artefacts& artefacts = test.artefacts;
  Progress progress("scans",
                    static_cast<std::int64_t>(artefacts.spheres.size() + artefacts.planes.size() +
                                              artefacts.repeated.size()));
  const Accuracy accuracy = measure_accuracy(artefacts, [&](const std::string& scan) {
    progress.advance();
    return test.cloud_of(scan);
  });
  progress.finish();
  output.document["subject"] = subject;
  if (artefacts.diagonal) output.document["diagonal_mm"] = *artefacts.diagonal;
  tell(accuracy, artefacts.diagonal, output);
  if (!flags.report) return;
  write_accuracy_report(*flags.report, subject, accuracy, artefacts.diagonal);
  output.document["report"] = *flags.report;
  output.say("the report is {}/report.md", *flags.report);
}

}  // namespace

void add_verify(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, verify_accuracy, "verify",
                  "accuracy by certified artefacts, as ISO 10360-13 and VDI/VDE 2634 state it");
  command.add_file("artefacts", flags.artefacts, "certified lengths and scans: .yaml");
  command.add("--rehearse", flags.rehearse, "artefacts and scans in the virtual world instead");
  command.add("--world", flags.devices.world, "of a rehearsal, as simulate has it");
  command.add_file("--calibrated", flags.calibrated,
                   "of a rehearsal: what reconstructs, where not the scanner as it truly is");
  command.add("-o,--output", flags.report, "a folder to write a report with pictures into");
  add_cloud_input_flags(command.app, flags.input);
  command.app.footer(
      "Examples:\n  slipstream verify artefacts.yaml -o report\n"
      "  slipstream verify --rehearse -o report");
}

}  // namespace slipstream::app
