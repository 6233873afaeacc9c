#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>
#include <unordered_set>
#include <vector>

#include "app/batch_plan.h"
#include "app/commands.h"
#include "app/manifest.h"
#include "app/reconstruct.h"
#include "base/parallel_rows.h"
#include "io/file.h"
#include "io/image_file.h"
#include "slipstream/recording.h"
#include "slipstream/scan_files.h"

namespace slipstream::app {
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

/// Pixels in all frames of a scan; a folder is judged by its first picture.
std::uint64_t pixels_of(const ScanFiles& scan) {
  const Size size = scan.frames.empty() ? RecordingReader(scan.path).header().format.size
                                        : read_frames({scan.frames.front()}).frames.size();
  return std::uint64_t{1} * size.width * size.height * frame_count(scan.sequence);
}

/// Unreadable scans cost little; their shard reports why.
void set_cost(ListedScans& listed, const ReconstructFlags& flags, Output& output) try {
  listed.cost =
      scan_count(listed, flags.every) * pixels_of(scan_files_in(listed.path, flags.changes));
} catch (const Error& error) {
  output.warn(error.what());
  listed.cost = 1;
}

/// Throws Error if two scans share an output. Like require_writable, but compares paths as text, so
/// that a million scans take seconds.
void require_distinct(const ReconstructFlags& flags) {
  require_writable(flags.files, {flags.scans.front()});
  std::unordered_set<std::string> outputs;
  for (const ScanName& scan : flags.scans) {
    for (const auto& [kind, path] : files_of_scan(flags.files, scan).named()) {
      throw_if(!outputs.insert(path).second,
               "{}: two scans would be written to this file, the second is {}; put {{name}} or "
               "{{window}} in the path to keep them apart",
               path, text_of(scan));
    }
  }
}

void plan_batch(const BatchFlags& parsed, Output& output) {
  BatchFlags flags = parsed;
  throw_if(flags.tasks < 1, "--tasks 0 is out of range; 1 or more");
  const std::string plan = flags.folder + "/batch.json";
  throw_if(fs::exists(plan), "{}: already holds a batch; name another folder", flags.folder);
  throw_if(flags.reconstruct.files.cloud == standard_output,
           "-o -: a batch writes files, not to standard output; name one, e.g. {{name}}.ply");

  // 1. List the scans and their cost, in pixels of all frames.
  require_valid(flags.reconstruct);
  std::vector<ListedScans> listed = listed_scans(flags.reconstruct);
  throw_if(listed.empty(), "no scans listed");
  for (ListedScans& scans : listed) {
    scans.path = fs::absolute(scans.path).string();
    if (scans.cost == 0) set_cost(scans, flags.reconstruct, output);
  }

  // 2. Refuse scans that would overwrite each other, before any shard has run.
  const std::uint64_t every = flags.reconstruct.every;
  flags.reconstruct.scans = scan_names(listed, every);
  require_distinct(flags.reconstruct);

  // 3. Write the plan: the list cut into shards of equal cost, and the arguments for every run.
  make_folder(flags.folder);
  write_file(flags.folder + "/scans.txt", text_of(cut_into_shards(listed, every, flags.tasks)));
  output.document = described("slipstream", 1, "version", SLIPSTREAM_VERSION, "tasks", flags.tasks,
                              "scans", flags.reconstruct.scans.size(), "arguments",
                              arguments_of(*flags.reconstruct.command, Arguments::all));
  write_file(plan, output.document.dump(2) + '\n');

  output.say("{}: {} scans in {} shards; slipstream batch run {} --shard 1/{}", flags.folder,
             flags.reconstruct.scans.size(), flags.tasks, flags.folder, flags.tasks);
}

struct Batch {
  std::uint64_t tasks = 0;
  ReconstructFlags flags{};
  std::vector<ListedScans> scans{};
};

Batch batch_in(const std::string& folder) {
  const std::string name = folder + "/batch.json";
  Batch batch;

  // 1. Read the plan.
  BatchPlan plan = batch_plan_from(read_text(name), name);
  batch.tasks = plan.tasks;

  // 2. Parse its arguments, as if given on the command line; CLI11 takes the last word first.
  CLI::App command;
  add_reconstruct_flags(command, batch.flags);
  std::reverse(plan.arguments.begin(), plan.arguments.end());

  try {
    command.parse(plan.arguments);
  } catch (const CLI::ParseError& error) {
    throw Error(fmt::format("{}: {}", name, error.what()));
  }

  // 3. The scans of all shards.
  batch.flags.settings = arguments_of(command, Arguments::settings);
  batch.flags.paths = {folder + "/scans.txt"};
  batch.scans = listed_scans(batch.flags);

  return batch;
}

void run_shard(const BatchFlags& flags, Output& output) {
  Batch batch = batch_in(flags.folder);

  // Both "3" and "3/8" name a shard; the second form must have the batch's number of tasks.
  const std::uint64_t shard = std::strtoull(flags.shard.c_str(), nullptr, 10);
  throw_if(!(shard >= 1 && shard <= batch.tasks &&
             (flags.shard == fmt::format("{}/{}", shard, batch.tasks) ||
              flags.shard == std::to_string(shard))),
           "--shard {0} is not in this batch; expected 1/{1} to {1}/{1}", flags.shard, batch.tasks);

  // A shard is a run of reconstruct that can always be resumed, with a manifest of its own.
  std::erase_if(batch.scans, [&](const ListedScans& listed) { return listed.shard != shard; });
  batch.flags.scans = scan_names(batch.scans, batch.flags.every);
  batch.flags.manifest = manifest_in(flags.folder, shard);
  batch.flags.resume = true;

  reconstruct_scans(std::move(batch.flags), output);
}

/// Totals over all shards.
struct Sums {
  std::uint64_t scans = 0, whole = 0, lines = 0;
  std::map<std::string, std::uint64_t> counts{};
  double seconds = 0;
};

/// Returns the lines of the merged manifest.
std::string merge_shard(const ReconstructFlags& flags, Manifest manifest, Sums& sums,
                        Output& output) {
  // Every output is read again for its checksum, so the scans are checked in parallel.
  std::vector<std::string> faults(flags.scans.size());
  for_each_row(static_cast<int>(faults.size()), [&](int row) {
    const ScanName& scan = flags.scans[row];
    faults[row] = why_not_done(manifest, scan, entry_for(scan, flags.settings),
                               files_of_scan(flags.files, scan).written());
  });

  // Lines of unfinished scans are kept too: the manifest shows why they failed.
  std::string lines;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const auto entry = manifest.entries.find(flags.scans[i]);
    if (entry != manifest.entries.end()) lines += app::line_of(entry->second);

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

  Progress progress("shards", shards.size());
  for (const auto& [shard, listed] : shards) {
    batch.flags.scans = scan_names(listed, batch.flags.every);
    const std::string lines =
        merge_shard(batch.flags, read_manifest(manifest_in(flags.folder, shard)), sums, output);
    file.write({bytes_of(lines)});
    progress.advance();
  }

  progress.finish();
  file.keep();
  output.document = described("manifest", path, "scans", sums.scans, "whole", sums.whole, "lines",
                              sums.lines, "counts", sums.counts, "seconds", sums.seconds);
  output.say("{} of {} scans complete, {} points, {:.1f} s of work: {}", sums.whole, sums.scans,
             sums.counts[std::string(name_of(Validity::valid))], sums.seconds, path);
}

}  // namespace

void add_batch(const Commands& program) {
  const Commands batch =
      program.add_group("batch", "reconstruct many scans on many machines, in shards");

  // 1. slipstream batch plan
  const auto [plan, planned] =
      batch.add(plan_batch, "plan", "divide scans into shards of equal cost");
  add_scans_flags(plan, planned.reconstruct);
  required(plan.add("--tasks", planned.tasks, "number of shards"));
  required(plan.add_output("--plan", planned.folder, "folder to create for the batch"));

  add_reconstruct_flags(plan.app, planned.reconstruct);
  plan.app.footer(
      "Example:\n  slipstream batch plan archive.txt --tasks 8 --plan plan -o "
      "/shared/{name}-{window}.ply\n  slipstream batch run plan --shard 1/8\n  slipstream batch "
      "merge plan");

  // 2. slipstream batch run
  const auto [run, shard] =
      batch.add(run_shard, "run", "reconstruct one shard, or what is left of it");
  required(run.add_file("plan", shard.folder, "folder of the batch"));
  required(run.add("--shard", shard.shard, "shard number, e.g. 3 or 3/8"));

  // 3. slipstream batch merge
  const auto [merge, merged] =
      batch.add(merge_batch, "merge", "check that all shards are complete and write one manifest");
  required(merge.add_file("plan", merged.folder, "folder of the batch"));
}

}  // namespace slipstream::app
