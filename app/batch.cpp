#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <unordered_set>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/manifest.h"
#include "app/reconstruct_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/recording.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct BatchFlags {
  ReconstructFlags reconstruct;
  std::string folder;
  std::uint64_t tasks = 0;
  std::string shard;  ///< "3" or "3/8"
};

std::string manifest_in(const std::string& folder, std::uint64_t shard) {
  return fmt::format("{}/shard-{:06}.jsonl", folder, shard);
}

/// Pixels of the frames of a scan; of a folder as of its first picture.
std::uint64_t pixels_of(const ScanFiles& scan) {
  const Size size = scan.frames.empty() ? RecordingReader(scan.path).header().format.size
                                        : read_frames({scan.frames.front()}).frames.size();
  return static_cast<std::uint64_t>(frame_count(scan.sequence)) *
         static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
}

/// What cannot be read costs little: its shard says why.
void set_cost(ListedScans& listed, const ReconstructFlags& flags, Output& output) {
  try {
    listed.cost = scan_count(listed, flags.every) *
                  pixels_of(scan_files_in(listed.path, flags.cloud.input.changes));
  } catch (const Error& error) {
    output.warn(error.what());
    listed.cost = 1;
  }
}

/// Throws Error where two scans have one output. As require_writable, but for a million scans in
/// seconds: by paths as they are written.
void require_distinct(const ReconstructFlags& flags) {
  require_writable(flags.files, {flags.scans.front()});
  std::unordered_set<std::string> outputs;
  for (const ScanName& scan : flags.scans) {
    for (const auto& [kind, path] : files_of_scan(flags.files, scan).named()) {
      if (outputs.insert(path).second) continue;
      throw Error(
          fmt::format("{}: two scans would be written to it, the second {}; {{name}} and "
                      "{{window}} in it stand for theirs",
                      path, text_of(scan)));
    }
  }
}

void plan_batch(const BatchFlags& given, Output& output) {
  BatchFlags flags = given;
  if (flags.tasks < 1) throw Error("--tasks 0 is out of range; 1 or more");
  const std::string plan = flags.folder + "/batch.json";
  if (fs::exists(plan)) {
    throw Error(fmt::format("{}: is a batch already; name another folder", flags.folder));
  }
  require_valid(flags.reconstruct);
  std::vector<ListedScans> listed = listed_scans(flags.reconstruct);
  if (listed.empty()) throw Error("no scans are listed");
  for (ListedScans& scans : listed) {
    scans.path = fs::absolute(scans.path).string();
    if (scans.cost == 0) set_cost(scans, flags.reconstruct, output);
  }
  const std::uint64_t every = flags.reconstruct.every;
  flags.reconstruct.scans = scan_names(listed, every);
  require_distinct(flags.reconstruct);
  make_folder(flags.folder);
  write_file(flags.folder + "/scans.txt", text_of(cut_into_shards(listed, every, flags.tasks)));
  output.document = {{"slipstream", 1},
                     {"version", SLIPSTREAM_VERSION},
                     {"tasks", flags.tasks},
                     {"scans", flags.reconstruct.scans.size()},
                     {"arguments", arguments_of(*flags.reconstruct.command, Arguments::all)}};
  write_file(plan, output.document.dump(2) + '\n');
  output.say("{}: {} scans in {} shards; slipstream batch run {} --shard 1/{}", flags.folder,
             flags.reconstruct.scans.size(), flags.tasks, flags.folder, flags.tasks);
}

/// A batch as it was planned.
struct Batch {
  std::uint64_t tasks = 0;
  ReconstructFlags flags{};
  std::vector<ListedScans> scans{};
};

Batch batch_in(const std::string& folder) {
  const std::string name = folder + "/batch.json";
  Batch batch;
  std::vector<std::string> arguments;
  try {
    const nlohmann::json plan = nlohmann::json::parse(read_text(name));
    if (plan.at("version") != SLIPSTREAM_VERSION) {
      throw Error(fmt::format("{}: is of version {}, the program of {}; plan again", name,
                              plan["version"].dump(), SLIPSTREAM_VERSION));
    }
    plan.at("tasks").get_to(batch.tasks);
    plan.at("arguments").get_to(arguments);
  } catch (const nlohmann::json::exception&) {
    throw Error(fmt::format("{}: is no plan of slipstream batch", name));
  }
  CLI::App command;
  add_reconstruct_flags(command, batch.flags);
  std::reverse(arguments.begin(), arguments.end());
  try {
    command.parse(arguments);
  } catch (const CLI::ParseError& error) {
    throw Error(fmt::format("{}: {}", name, error.what()));
  }
  batch.flags.settings = arguments_of(command, Arguments::settings);
  batch.flags.paths = {folder + "/scans.txt"};
  batch.scans = listed_scans(batch.flags);
  return batch;
}

void run_shard(const BatchFlags& flags, Output& output) {
  Batch batch = batch_in(flags.folder);
  const std::uint64_t shard = std::strtoull(flags.shard.c_str(), nullptr, 10);
  if (shard < 1 || shard > batch.tasks ||
      (flags.shard != fmt::format("{}/{}", shard, batch.tasks) &&
       flags.shard != std::to_string(shard))) {
    throw Error(fmt::format("--shard {} is none of the batch; 1/{} to {}/{}", flags.shard,
                            batch.tasks, batch.tasks, batch.tasks));
  }
  std::erase_if(batch.scans, [&](const ListedScans& listed) { return listed.shard != shard; });
  batch.flags.scans = scan_names(batch.scans, batch.flags.every);
  batch.flags.manifest = manifest_in(flags.folder, shard);
  batch.flags.resume = true;
  reconstruct_scans(std::move(batch.flags), output);
}

/// What merging adds up.
struct Sums {
  std::uint64_t scans = 0, whole = 0, lines = 0;
  std::map<std::string, std::uint64_t> counts{};
  double seconds = 0;
};

/// Returns the lines of the merged manifest.
std::string merge_shard(const ReconstructFlags& flags, Manifest manifest, Sums& sums,
                        Output& output) {
  std::vector<std::string> faults(flags.scans.size());
  for_each_row(static_cast<int>(faults.size()), [&](int row) {
    const ScanName& scan = flags.scans[static_cast<std::size_t>(row)];
    faults[static_cast<std::size_t>(row)] =
        why_not_done(manifest, scan, entry_for(scan, flags.settings),
                     files_of_scan(flags.files, scan).written());
  });
  std::string lines;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const auto entry = manifest.entries.find(flags.scans[i]);
    if (entry != manifest.entries.end()) lines += line_of(entry->second);
    if (!faults[i].empty()) {
      output.tell_failure(fmt::format("{}: {}", text_of(flags.scans[i]), faults[i]));
      output.exit_code = 2;
      continue;
    }
    ++sums.whole;
    if (entry->second["seconds"].is_number())
      sums.seconds += entry->second["seconds"].get<double>();
    for (const auto& [name, count] : entry->second["counts"].items()) {
      if (count.is_number_unsigned()) sums.counts[name] += count.get<std::uint64_t>();
    }
  }
  sums.scans += faults.size();
  sums.lines += manifest.lines;
  return lines;
}

void merge_batch(const BatchFlags& flags, Output& output) {
  Batch batch = batch_in(flags.folder);
  std::map<std::uint64_t, std::vector<ListedScans>> shards;
  for (ListedScans& listed : batch.scans) shards[listed.shard].push_back(std::move(listed));
  const std::string path = flags.folder + "/manifest.jsonl";
  OutputFile file(path);
  Sums sums;
  for (const auto& [shard, listed] : shards) {
    batch.flags.scans = scan_names(listed, batch.flags.every);
    const std::string lines =
        merge_shard(batch.flags, read_manifest(manifest_in(flags.folder, shard)), sums, output);
    file.write({std::span(reinterpret_cast<const std::uint8_t*>(lines.data()), lines.size())});
  }
  file.keep();
  output.document = {{"manifest", path},    {"scans", sums.scans},   {"whole", sums.whole},
                     {"lines", sums.lines}, {"counts", sums.counts}, {"seconds", sums.seconds}};
  output.say("{} of {} scans are whole, {} points, {:.1f} s of work: {}", sums.whole, sums.scans,
             sums.counts[std::string(name_of(Validity::valid))], sums.seconds, path);
}

}  // namespace

void add_batch(CLI::App& program, Command& chosen) {
  CLI::App* const batch = program.add_subcommand("batch", "many scans on many machines, in shards");
  batch->require_subcommand(1);
  const auto [plan, planned] =
      add_command(*batch, chosen, plan_batch, "plan", "cuts scans by their cost into shards");
  add_scans_flags(plan, planned.reconstruct);
  plan.add("--tasks", planned.tasks, "into so many shards")->required()->default_str("");
  plan.add_output("--plan", planned.folder, "folder of the batch, which is made")
      ->required()
      ->default_str("");
  add_reconstruct_flags(plan.app, planned.reconstruct);
  plan.app.footer(
      "Example:\n  slipstream batch plan archive.txt --tasks 8 --plan plan -o "
      "/shared/{name}-{window}.ply\n  slipstream batch run plan --shard 1/8\n  slipstream batch "
      "merge plan");
  const auto [run, shard] =
      add_command(*batch, chosen, run_shard, "run", "does one shard, or what is left of it");
  run.add_file("plan", shard.folder, "folder of the batch")->required();
  run.add("--shard", shard.shard, "which, as 3 or 3/8")->required()->default_str("");
  const auto [merge, merged] = add_command(*batch, chosen, merge_batch, "merge",
                                           "says whether all is there and whole; one manifest");
  merge.add_file("plan", merged.folder, "folder of the batch")->required();
}

}  // namespace slipstream::app
