#include "app/reconstruct_flags.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "io/file.h"
#include "slipstream/scan_files.h"

namespace slipstream::app {
namespace {

void add_output_flags(CLI::App& command, ReconstructFlags& flags) {
  const FlagGroup group{command, "What to write"};
  ResultFiles& files = flags.files;

  // Points: clouds and meshes.
  group.add_output("-o,--output", files.cloud,
                   "point cloud: .ply, .pcd or .xyz; - writes .ply to standard output");
  group.add_output("--mesh", files.mesh,
                   "triangle mesh textured with the camera's picture: .ply, .stl, .obj or .glb");

  // Maps on the camera's grid.
  group.add_output("--depth", files.depth, "depth map, mm: .tiff");
  group.add_output("--coordinate", files.coordinate, "projector coordinate, 0 to 1: .tiff");
  group.add_output("--phase", files.phase, "wrapped phase, rad: .tiff");
  group.add_output("--modulation", files.modulation, "modulation B, grey levels: .tiff");
  group.add_output("--mean", files.mean, "mean A, grey levels: .tiff");
  group.add_output("--epipolar", files.epipolar,
                   "distance from the epipolar line (--axis both), projector pixels: .tiff");
  group.add_output("--motion-map", files.motion,
                   "phase change from frame to frame (--motion), rad: .tiff");

  group.add_output("--reflection-map", files.reflection,
                   "error that light from other surfaces may cause (--reflection), standard "
                   "deviations by noise: .tiff");

  group.add_output(
      "--preview", files.preview,
      "picture of the depth with a scale; without a scanner, of modulation and phase: .png");

  // The points of the cloud: how many, and with which values.
  group.add("--subsample", flags.subsample, "keep every Nth pixel of the cloud: 1, 2 or 4");
  group.add("--normals", flags.normals, "add surface normals to the cloud, from 5x5 pixels");
  group.add("--uncertainty", flags.job.uncertainty,
            "add each point's standard deviation to the cloud, from the frames' noise");
}

void set_end(ListedScans& listed, const ScanChanges& changes) {
  const std::string& path = listed.path;
  std::uint64_t count = 0;

  // Windows can only be counted by opening the recording.
  try {
    count = window_count(scan_files_in(path, changes));
  } catch (const Error&) {
    return listed.windows.reset();  // the reader reports why and continues
  }

  throw_if(listed.windows->first >= count, "{}: has {} windows; none in the range {}:", path, count,
           listed.windows->first);
  listed.windows->end = std::min(listed.windows->end, count);
}

}  // namespace

void add_scans_flags(const FlagGroup& command, ReconstructFlags& flags) {
  required(command.add_file(
      "scans", flags.paths,
      "scan folders (pictures with scan.yaml or flags), recordings, or lists of them: .txt"));
  command.add("--windows", flags.windows,
              "recordings, and folders of many frames: windows A to B, B excluded; ':' for all");
}

void add_reconstruct_flags(CLI::App& subcommand, ReconstructFlags& flags) {
  const FlagGroup command{subcommand};
  flags.command = &subcommand;

  command.add("--every", flags.every, "keep every Nth window");
  ReconstructSettings& settings = flags.job.reconstruct;
  add_backend_flag(command, settings);

  command.add_named(
      "--cue-rule", settings.cue_rule, cue_rule_named, name_of(settings.cue_rule),
      "how a cue in the same frames gives the fringe order: consensus, likelihood or published");

  command.add_file("--second-camera", flags.changes.further_cameras,
                   "scan folder or recording of a second camera, and given again of a third and "
                   "so on; default: the scan's own");
  command.add_file("--second-scanner", flags.changes.further_scanners,
                   "scanner file of the second camera with the same projector, and given again of "
                   "the third and so on; default: their own");

  command.add("--one-camera", flags.one_camera, "use only the first camera of a scan with several");
  command.add("--fuse", flags.job.fuse,
              "two cameras: instead of matching their phases, fuse the points that each measures "
              "with the projector; three or more cameras always do");
  command.add("--match-window", flags.job.match_window,
              "two cameras: half-width of the matching window, pixels");

  add_output_flags(subcommand, flags);
  add_cloud_flags(subcommand, flags.changes, flags.job);
}

std::vector<ListedScans> listed_scans(const ReconstructFlags& flags) {
  throw_if(flags.every < 1, "--every 0 is out of range; 1 or more");
  std::vector<ListedScans> scans;
  for (const std::string& path : flags.paths) {
    // A path is a scan, unless it ends in .txt: a list of scans.
    if (lower_case_extension(path) != ".txt") {
      scans.push_back({.path = path});
      continue;
    }

    for (ListedScans& listed : scan_list_from(read_text(path, largest_file), path)) {
      listed.path = (fs::path(path).parent_path() / listed.path).string();  // relative to the list
      scans.push_back(std::move(listed));
    }
  }

  // Ranges end with the recording. A list from batch plan states the end and the cost of each
  // range, which saves opening every recording again.
  for (ListedScans& listed : scans) {
    if (flags.windows && !listed.windows) {
      listed.windows = window_range_from(*flags.windows);
      listed.cost = 0;
    }
    const bool known =
        listed.cost > 0 && listed.windows && listed.windows->end != WindowRange::last;
    if (listed.windows && !known) set_end(listed, flags.changes);
  }

  return scans;
}

std::vector<std::string> arguments_of(const CLI::App& subcommand, Arguments wanted) {
  // Which scans, and the number of threads, do not affect an output's content.
  static const std::set<std::string> of_run{"rig",      "json",   "threads", "windows",
                                            "manifest", "resume", "tasks",   "plan"};
  std::vector<std::string> arguments;

  for (const CLI::Option* const option : subcommand.get_options()) {
    if (option->get_lnames().empty() || of_run.contains(option->get_lnames().front())) continue;
    const std::string name = option->get_lnames().front(), type = option->get_type_name();
    const bool is_path = type == file_type || type == output_type;
    if (wanted == Arguments::settings && (is_path || name == "every")) continue;

    // A batch may run from another folder, so its paths become absolute.
    for (const std::string& value : option->results()) {
      arguments.push_back(
          fmt::format("--{}={}", name, is_path ? fs::absolute(value).string() : value));
    }
  }

  return arguments;
}

void require_valid(const ReconstructFlags& flags) {
  require_valid(flags.job.reconstruct.clean);
  const int every = flags.subsample;
  require_in_range(every == 1 || every == 2 || every == 4, "--subsample", every, "1, 2 or 4");
}

}  // namespace slipstream::app
