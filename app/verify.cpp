#include <optional>
#include <string>

#include <fmt/format.h>

#include "app/cloud_input.h"
#include "app/commands.h"
#include "app/progress.h"
#include "app/virtual_flags.h"
#include "slipstream/accuracy/accuracy_report.h"
#include "slipstream/accuracy/rehearsal.h"
#include "slipstream/error/error.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/strategy/registry.h"

namespace slipstream::app {
namespace {

struct VerifyFlags {
  std::optional<std::string> artefacts, report, calibrated;
  bool rehearse = false;
  CloudInputFlags input;
};

nlohmann::json json_of(const FormDeviation& form) {
  return {{"range_mm", form.range},
          {"range_95_mm", form.dispersion},
          {"rms_mm", form.rms},
          {"points", form.points}};
}

nlohmann::json json_of(const SpheresAccuracy& position) {
  nlohmann::json told{{"scan", position.scan}, {"spheres", nlohmann::json::array()}};
  for (const SphereAccuracy& sphere : position.spheres) {
    told["spheres"].push_back({{"size_mm", sphere.size}, {"form", json_of(sphere.form)}});
  }
  if (position.spacing) told["spacing_mm"] = *position.spacing;
  return told;
}

void tell(const Accuracy& accuracy, const Artefacts& artefacts, Output& output) {
  nlohmann::json& document = output.document;
  for (const AccuracyFigure& figure : accuracy_figures(accuracy, artefacts)) {
    nlohmann::json& told = document["figures"][std::string(figure.key)];
    told["mm"] = figure.millimetres;
    if (artefacts.diagonal) told["share_of_diagonal"] = figure.share;
    output.say("{}: {:.4f} mm{}", figure.what, figure.millimetres,
               artefacts.diagonal ? fmt::format(", {:.3f} per mille", 1000 * figure.share) : "");
  }
  if (const auto scale = scale_error(accuracy, artefacts)) {
    document["scale_error"] = *scale;
    output.say("dimension trueness: {:+.4f} % of the spheres' distance", 100 * *scale);
  }
  for (const SpheresAccuracy& position : accuracy.spheres) {
    document["spheres"].push_back(json_of(position));
  }
  for (const PlaneAccuracy& plane : accuracy.planes) {
    document["planes"].push_back(
        {{"scan", plane.scan}, {"form", json_of(plane.form)}, {"bending_mm", plane.bending}});
  }
  if (accuracy.repeated) {
    document["repeated"] = {{"scans", accuracy.repeated->scans},
                            {"pixels", accuracy.repeated->pixels},
                            {"sigma_mm", accuracy.repeated->sigma}};
  }
}

/// A test, and in a line what it is of.
struct Test {
  Rehearsal rehearsal;
  std::string subject;
};

Test rehearsed(const VerifyFlags& flags) {
  VirtualFlags devices;
  devices.scene = "board";  // it makes way for the artefacts
  devices.scanner = flags.input.input.scanner;
  const VirtualWorld world = world_from(devices);
  const Scanner calibrated =
      flags.calibrated ? read_scanner(*flags.calibrated) : as_calibrated(world);
  ReconstructSettings settings = flags.input.settings;
  settings.clean = clean_settings_from(flags.input.clean);
  const Sequence sequence = sequence_for(flags.input.input.scan, world.scanner);
  return {rehearsal(world, sequence, calibrated, settings),
          fmt::format("Rehearsed in the virtual world, {}", label_of(sequence.strategy))};
}

Test of_artefacts(const VerifyFlags& flags, Output& output) {
  Artefacts artefacts = read_artefacts(*flags.artefacts);
  if (!artefacts.diagonal && flags.input.input.scanner) {
    artefacts.diagonal = std::sqrt(3) * measured_cube(read_scanner(*flags.input.input.scanner));
  }
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
  tell(accuracy, artefacts, output);
  if (!flags.report) return;
  write_accuracy_report(*flags.report, subject, accuracy, artefacts);
  output.document["report"] = *flags.report;
  output.say("the report is {}", *flags.report);
}

}  // namespace

void add_verify(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, verify_accuracy, "verify",
                  "accuracy by certified artefacts, as ISO 10360-13 and VDI/VDE 2634 state it");
  command.add("artefacts", flags.artefacts, "certified lengths and scans: .yaml");
  command.add("--rehearse", flags.rehearse, "artefacts and scans in the virtual world instead");
  command.add_file("--calibrated", flags.calibrated,
                   "of a rehearsal: what reconstructs, where not the scanner as it truly is");
  command.add("-o,--output", flags.report, "a page with tables and pictures: .html");
  add_cloud_input_flags(command.app, flags.input);
  command.app.footer(
      "Examples:\n  slipstream verify artefacts.yaml -o report.html\n"
      "  slipstream verify --rehearse -o report.html");
}

}  // namespace slipstream::app
