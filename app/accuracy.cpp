#include "simulate/accuracy.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/report_facts.h"
#include "app/source_flags.h"
#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/image_file.h"
#include "io/plot.h"
#include "io/result_files.h"
#include "simulate/accuracy_report.h"
#include "simulate/comparison.h"
#include "simulate/rehearsal.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"

namespace slipstream::app {
namespace {

struct CompareFlags {
  std::vector<std::string> scenes, worlds{"bench"}, strategies;
  VirtualFlags devices;
  std::string folder;
};

struct Row {
  std::string scene, world, strategy;
  int frames = 0;
  ComparedSequence compared{};
};

std::vector<Sequence> sequences_from(const CompareFlags& flags, Size projector) {
  std::vector<Strategy> strategies;
  for (const std::string& label : flags.strategies) strategies.push_back(strategy_labelled(label));

  if (strategies.empty()) strategies = strategies_to_compare();
  std::vector<Sequence> sequences;
  for (const Strategy& strategy : strategies) {
    sequences.push_back({.strategy = strategy, .projector = projector});
    require_shown(sequences.back());
  }

  return sequences;
}

std::vector<Row> compared_rows(const CompareFlags& flags) {
  std::vector<std::string> scenes = flags.scenes;

  // Scenes named as arguments go before --scene, and a mesh goes before both.
  if (scenes.empty()) scenes = {flags.devices.scene};
  if (flags.devices.mesh) scenes = {flags.devices.mesh->string()};
  Progress progress("scenes", scenes.size() * flags.worlds.size());

  // Every strategy sees the same world, scene by scene.
  std::vector<Row> rows;
  for (const std::string& scene : scenes) {
    for (const std::string& name : flags.worlds) {
      VirtualFlags devices = flags.devices;
      devices.scene = scene;
      devices.world = name;
      const VirtualWorld world = world_from(devices);
      const std::vector<Sequence> sequences = sequences_from(flags, world.scanner.projector.size);

      std::vector<ComparedSequence> all = compare(world, sequences);
      for (std::size_t i = 0; i < all.size(); ++i) {
        const Strategy& strategy = sequences[i].strategy;
        rows.push_back({scene, name, label_of(strategy), frame_count(strategy), std::move(all[i])});
      }

      progress.advance();
    }
  }

  return rows;
}

const std::vector<std::string> columns_of_comparison{
    "scene", "world",         "strategy",       "frames", "complete",    "RMS (predicted)",
    "noise", "error / sigma", "beyond 5 sigma", "flying", "wrong order", "decoding"};

std::vector<std::string> cells_of(const Row& row) {
  const CloudErrors& errors = row.compared.errors;
  const auto percent = [](double share) { return fmt::format("{:.3f} %", 100 * share); };
  const auto mm = [](double length) { return fmt::format("{:.3f} mm", length); };

  return {row.scene,
          row.world,
          row.strategy,
          std::to_string(row.frames),
          fmt::format("{:.1f} %", 100 * errors.completeness),
          fmt::format("{:.3f} ({:.3f}) mm", errors.rms, errors.predicted),
          mm(row.compared.repeatability),
          fmt::format("{:.2f}", errors.normalised_rms),
          percent(errors.beyond_5),
          percent(errors.flying),
          percent(errors.wrong_order),
          fmt::format("{:.2f} ms", row.compared.decode_ms)};
}

/// RMS over strategies in the table's order, one line per scene and world.
LinePlot plot_of(const std::vector<Row>& rows) {
  LinePlot plot{.title = "RMS error of depth",
                .x_label = "strategy, in the table's order",
                .y_label = "mm",
                .y_scale = PlotScale::logarithmic,
                .lines = {}};

  // Rows come scene by scene, so a new label begins a new line.
  for (const Row& row : rows) {
    const std::string label = row.scene + ", " + row.world;
    if (plot.lines.empty() || plot.lines.back().label != label) {
      plot.lines.push_back({.label = label, .x = {}, .y = {}});
    }

    PlotLine& line = plot.lines.back();
    line.add(static_cast<double>(line.x.size() + 1), row.compared.errors.rms);
  }

  return plot;
}

void write_comparison(const fs::path& folder, const std::vector<Row>& rows) {
  make_folder(folder);
  write_plot(folder / "rms.png", plot_of(rows));

  Page page("Comparison of strategies");
  page.table(columns_of_comparison);
  for (const Row& row : rows) page.row(cells_of(row));

  page.picture("RMS error of depth", "rms.png");

  // A picture of each cloud, numbered as the table's rows.
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string picture = fmt::format("cloud-{:02}.png", i + 1);
    write_depth_preview(folder / picture, rows[i].compared.cloud);
    page.picture(fmt::format("{}, {}, {}", rows[i].scene, rows[i].world, rows[i].strategy),
                 picture);
  }

  write_page(folder / "comparison.html", page);
}

void compare_strategies(const CompareFlags& flags, Output& output) {
  const std::vector<Row> rows = compared_rows(flags);

  // The table, in Markdown.
  output.say("| {} |", fmt::join(columns_of_comparison, " | "));
  output.say("|{}",
             fmt::join(std::vector<std::string>(columns_of_comparison.size(), " --- |"), ""));

  for (const Row& row : rows) {
    output.say("| {} |", fmt::join(cells_of(row), " | "));
    const CloudErrors& errors = row.compared.errors;
    output.add_to("rows", "scene", row.scene, "world", row.world, "strategy", row.strategy,
                  "frames", row.frames, "points", errors.points, "completeness",
                  errors.completeness, "rms_mm", errors.rms, "predicted_mm", errors.predicted,
                  "repeatability_mm", row.compared.repeatability, "normalised_rms",
                  errors.normalised_rms, "beyond_5_sigma", errors.beyond_5, "flying", errors.flying,
                  "wrong_order", errors.wrong_order, "decode_ms", row.compared.decode_ms);
  }

  if (flags.folder.empty()) return;
  write_comparison(flags.folder, rows);
  output.document["folder"] = flags.folder;
  output.say("table, plot and pictures are in {}", flags.folder);
}

struct VerifyFlags {
  std::vector<std::string> limits;
  std::optional<std::string> artefacts, report, calibrated;
  bool rehearse = false;
  VirtualFlags devices;  ///< rehearsal only: its world
  ScanChanges changes;
  ScanJobSettings job;
};

std::optional<double> value_of(const std::optional<Estimate>& estimate) {
  return estimate ? std::optional(estimate->value) : std::nullopt;
}

/// Limits from KEY=MM.
std::vector<std::pair<std::string, double>> limits_from(const std::vector<std::string>& texts) {
  const std::vector<std::string> known = accuracy_keys();

  std::vector<std::pair<std::string, double>> limits;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    const std::string key = text.substr(0, equals);
    throw_if(std::ranges::find(known, key) == known.end(),
             "--limits {}: expected KEY=MM with one of: {}{}", text, fmt::join(known, ", "),
             did_you_mean(key, known));

    const auto limit =
        equals == std::string::npos ? std::nullopt : number_in<double>(text.substr(equals + 1));
    throw_if(!limit || !(*limit > 0) || !std::isfinite(*limit),
             "--limits {}: expected a length above 0 mm, as in {}=0.1", text, key);
    limits.emplace_back(key, *limit);
  }

  return limits;
}

std::string in_limit(const AccuracyFigure& figure) {
  return fmt::format(", limit {:g} mm: {}", *figure.limit, figure.fails() ? "fail" : "pass");
}

void tell(const Accuracy& accuracy, const std::vector<AccuracyFigure>& figures,
          std::optional<double> diagonal, Output& output) {
  for (const AccuracyFigure& figure : figures) {
    const auto& [value, uncertainty] = figure.measured;
    const std::string key(figure.key);
    output.object("figures_mm")[key] = value;
    output.object("uncertainties_mm")[key] = uncertainty;

    output.say("{}: {:.4f} mm{}{}", figure.what, value,
               diagonal ? fmt::format(", {:.3f} per mille", 1000 * value / *diagonal) : "",
               figure.limit ? in_limit(figure) : "");
    if (!figure.limit) continue;
    output.object("limits_mm")[key] = *figure.limit;
    output.object("passed")[key] = !figure.fails();
  }

  for (const ShapeAccuracy& shape : accuracy.shapes) {
    output.add_to(shape.size ? "spheres" : "planes", "scan", shape.scan, "form_mm",
                  shape.range.value, "form_95_mm", shape.range_95.value, "rms_mm", shape.rms,
                  "points", shape.points, "size_mm", value_of(shape.size), "spacing_mm",
                  value_of(shape.spacing), "planarity_mm", value_of(shape.bending));
  }
}

/// An acceptance test, and facts for its report.
struct Test {
  Rehearsal rehearsal;
  std::string subject;
  Facts facts{};               ///< about scanner and patterns
  Facts budget{};              ///< see AccuracyReport; empty without a report
  bool exact_scanner = false;  ///< the virtual world's own
};

/// The error of a scan's depths by its sources.
Facts budget_of(Scan scan, ScanJobSettings settings, const std::string& name) {
  settings.uncertainty = true;
  settings.keep_refused = true;  // the test itself refuses it
  const ScanResult result = ScanJob(settings)(std::move(scan), name);
  return facts_of(*result.budget);
}

Test rehearsed(const VerifyFlags& flags) {
  VirtualFlags devices = flags.devices;
  devices.scene = "board";  // removed before the artefacts are placed
  devices.scanner_file = flags.changes.scanner;

  const VirtualWorld world = world_from(devices);
  const Scanner calibrated =
      flags.calibrated ? read_scanner(*flags.calibrated) : as_calibrated(world);

  require_valid(flags.job.reconstruct.clean);
  const Sequence sequence = sequence_for(flags.changes.sequence, world.scanner);

  Test test{.rehearsal = rehearsal(world, sequence, calibrated, flags.job.reconstruct),
            .subject = fmt::format("Rehearsed in the virtual world {}: {}", devices.world,
                                   label_of(sequence.strategy)),
            .exact_scanner = !flags.calibrated};
  add_scanner(test.facts, calibrated, flags.calibrated.value_or(""));
  test.facts.emplace_back("patterns", label_of(sequence.strategy));

  if (flags.report) {
    const VirtualScan board =
        take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
    test.budget = budget_of({.frames = board.frames, .sequence = sequence, .scanner = calibrated},
                            flags.job, "a board");
  }
  return test;
}

/// Sets the facts about the scanner and the patterns of a scan, and its budget. Ignores a cloud.
void set_facts(const std::string& path, const VerifyFlags& flags, Test& test, Output& output) {
  if (is_cloud_file(path)) return;

  Output held = output.held();  // its warnings are printed when the scan is reconstructed
  Scan scan = load_checkable(path, flags.changes, false, held);
  if (scan.scanner) {
    add_scanner(test.facts, *scan.scanner,
                flags.changes.scanner.value_or((fs::path(path) / "scanner.yaml").string()));
  }
  test.facts.emplace_back("patterns", label_of(scan.sequence.strategy));
  for (const auto& [part, celsius] : scan_files_in(path, flags.changes).temperatures) {
    add_temperature(test.facts, part, celsius, celsius);
  }
  test.budget = budget_of(std::move(scan), flags.job, path);
}

Test of_artefacts(const VerifyFlags& flags, Output& output) {
  Artefacts artefacts = read_artefacts(*flags.artefacts);
  DistinctFiles files;
  for (const auto* scans : {&artefacts.spheres, &artefacts.planes, &artefacts.repeated}) {
    for (const std::string& scan : *scans) files.add_input(scan);
  }

  Test test{.rehearsal = {}, .subject = "Artefacts of " + *flags.artefacts};
  if (flags.report) {
    files.add_output_folder(*flags.report);
    for (const auto* scans : {&artefacts.spheres, &artefacts.planes, &artefacts.repeated}) {
      if (scans->empty()) continue;
      set_facts(scans->front(), flags, test, output);
      break;
    }
  }

  test.rehearsal = {std::move(artefacts), [&](const std::string& scan) {
                      return organised_cloud(scan, flags.changes, flags.job, output).cloud;
                    }};
  return test;
}

void verify_accuracy(const VerifyFlags& flags, Output& output) {
  throw_if(!flags.rehearse && !flags.artefacts,
           "nothing to verify: give an artefacts file (.yaml) or --rehearse");
  throw_if(flags.rehearse && flags.artefacts.has_value(),
           "--rehearse uses virtual artefacts; drop it, or the artefacts file {}",
           flags.artefacts.value_or(""));

  // The artefacts come from a file and their scans, or from a rehearsal in the virtual world.
  const auto limits = limits_from(flags.limits);
  const Test test = flags.rehearse ? rehearsed(flags) : of_artefacts(flags, output);
  const Artefacts& artefacts = test.rehearsal.artefacts;
  Progress progress("scans",
                    artefacts.spheres.size() + artefacts.planes.size() + artefacts.repeated.size());

  const Accuracy accuracy = measure_accuracy(artefacts, [&](const std::string& scan) {
    progress.advance();
    return test.rehearsal.cloud_of(scan);
  });

  std::vector<AccuracyFigure> figures = accuracy_figures(accuracy);
  set_limits(figures, limits);
  const Verdict verdict = verdict_of(accuracy, figures, test.exact_scanner);

  progress.finish();
  output.document["subject"] = test.subject;
  if (artefacts.diagonal) output.document["diagonal_mm"] = *artefacts.diagonal;
  tell(accuracy, figures, artefacts.diagonal, output);

  output.document["verdict"] = verdict.words;
  output.say("{}", verdict.words);
  if (std::ranges::any_of(figures, &AccuracyFigure::fails)) output.exit_code = 2;

  if (!flags.report) return;
  Facts facts = facts_of_run(output);
  facts.emplace_back("subject", test.subject);
  facts.insert(facts.end(), test.facts.begin(), test.facts.end());
  write_accuracy_report(*flags.report, {artefacts, accuracy, figures, verdict, facts, test.budget});
  output.document["report"] = *flags.report;
  output.say("the report is {}/report.html", *flags.report);
}

}  // namespace

void add_verify(const Commands& program) {
  const auto [command, flags] =
      program.add(verify_accuracy, "verify",
                  "acceptance test with certified artefacts (ISO 10360-13, VDI/VDE 2634)");

  command.add_file("artefacts", flags.artefacts, "certified lengths and their scans: .yaml");
  command.add("--rehearse", flags.rehearse, "use virtual artefacts and scans instead");
  command.add("--world", flags.devices.world, "virtual world of a rehearsal; see simulate");
  command.add_file("--calibrated", flags.calibrated,
                   "rehearsal: scanner file used to reconstruct; default: the true scanner");

  command.add("--limits", flags.limits,
              "largest allowed figures, mm, as in probing_form=0.1 flatness=0.2; exit code 2 if "
              "one is exceeded");
  command.add_output("-o,--output", flags.report, "folder for a report with pictures",
                     output_folder_type);

  add_cloud_flags(command.app, flags.changes, flags.job);
  command.common({"--rehearse", "--limits", "--output", "--world", "--scanner", "--calibrated"});
  command.examples(
      {"verify artefacts.yaml -o report", "verify --rehearse -o report --limits probing_size=0.5"});
}

void add_compare(const Commands& program) {
  const auto [command, flags] =
      program.add(compare_strategies, "compare",
                  "compare strategies in the virtual world: errors, noise, wrong points, time");

  add_virtual_flags(command.app, flags.devices);

  // These take several values here.
  for (const char* single : {"--scene", "--world"}) {
    command.app.remove_option(command.app.get_option(single));
  }

  command.add("scenes", flags.scenes, "scenes, as in simulate --scene; default: statue");
  command.add("--world", flags.worlds, "virtual worlds, as in simulate; several are compared")
      ->default_str("bench");

  command.add(
      "--strategies", flags.strategies,
      "strategies with settings after commas, e.g. \"pcmp, steps 5\"; default: a usual set");
  command.add_output("-o,--output", flags.folder, "folder for the table, the plot and pictures",
                     output_folder_type);

  command.common({"--world", "--strategies", "--output", "--mesh", "--camera", "--seed"});
  command.examples({"compare statue boxes --world bench harsh -o comparison",
                    "compare --move 0 0 0.5 --strategies \"pcmp, steps 3\" \"pmp, steps 6\""});
}

}  // namespace slipstream::app
