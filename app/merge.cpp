#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/merge_report.h"
#include "app/scan_flags.h"
#include "base/numbers.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "io/model_file.h"
#include "io/pose_list.h"
#include "merge/fused_model.h"
#include "merge/hole_filling.h"
#include "merge/joint_alignment.h"
#include "merge/model_surface.h"
#include "merge/start_poses.h"
#include "merge/turntable.h"
#include "merge/turntable_views.h"

namespace slipstream::app {
namespace {

struct MergeFlags {
  std::vector<std::string> inputs;
  std::string output, mesh, poses, report, start;
  std::string unit = "mm";
  double spacing = 0, widest_hole = 0;  ///< mm
  bool turntable = false;
  std::optional<double> turn_step;  ///< degrees
  ScanChanges changes;
  ScanJobSettings job;
  FlagsOfScans of_scans;
};

/// Millimetres of a unit of length.
double millimetres_of(const std::string& unit) {
  static const std::map<std::string, double> units{{"mm", 1}, {"cm", 10}, {"m", 1000}};
  const auto found = units.find(unit);
  throw_if(found == units.end(), "--unit '{}': use mm, cm or m", unit);
  return found->second;
}

void scale(StoredCloud& stored, double unit) {
  const auto factor = static_cast<float>(unit);
  for (Image<float>* image : {&stored.cloud.x, &stored.cloud.y, &stored.cloud.z}) {
    for (float& value : *image) value *= factor;
  }
  if (!stored.uncertainty) return;
  for (Image<float>* image :
       {&stored.uncertainty->x, &stored.uncertainty->y, &stored.uncertainty->z}) {
    for (float& value : *image) value *= factor;
  }
}

/// Diagonal of the box around a view, mm.
float extent_of(const View& view) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& point : view.points) box.extend(point);
  return box.diagonal().norm();
}

/// Views of one object are of about one size: a factor of a hundred is another unit.
void require_one_unit(const std::vector<View>& views) {
  constexpr float most = 100;
  const auto by_size = [](const View& a, const View& b) { return extent_of(a) < extent_of(b); };
  const auto [least, largest] = std::minmax_element(views.begin(), views.end(), by_size);
  throw_if(extent_of(*largest) > most * extent_of(*least),
           "{} is {:.3g} long and {} is {:.3g}: one of them is in another unit; convert it first",
           largest->name, extent_of(*largest), least->name, extent_of(*least));
}

/// Points much closer than those of the views tell nothing more, and cost memory without a bound.
void require_coarse_enough(const MergeFlags& flags, const std::vector<View>& views) {
  constexpr double finest = 0.25;  // spacings of the views

  float least = views.front().spacing;
  for (const View& view : views) least = std::min(least, view.spacing);
  throw_if(flags.spacing > 0 && flags.spacing < finest * least,
           "--spacing {} mm: the views' points are {:.3g} mm apart; use {:.3g} or more",
           flags.spacing, least, finest * least);
}

std::vector<View> read_views(const MergeFlags& flags, Output& output) {
  const double unit = millimetres_of(flags.unit);
  std::vector<View> views;
  Progress progress("views", flags.inputs.size());

  for (const std::string& path : flags.inputs) {
    StoredCloud stored;
    if (is_cloud_file(path)) {
      stored = loaded_cloud(path, output, unit);
      move_to_camera(stored.cloud, stored.uncertainty ? &*stored.uncertainty : nullptr);
      scale(stored, unit);
      keep_box(stored.cloud, flags.job.reconstruct.clean);
    } else {
      stored = organised_cloud(path, flags.changes, flags.job, output);
    }
    views.push_back(naming(path, [&] {
      const Image<Colour>& colours = stored.cloud.colour;
      return view_of(stored.cloud, uncertainty_of(stored), path,
                     colours.empty() ? nullptr : &colours);
    }));
    progress.advance();
  }

  require_one_unit(views);
  require_coarse_enough(flags, views);

  // Most programs of other fields write metres.
  constexpr float smallest = 5;
  const float extent = extent_of(views.front());
  if (extent < smallest && unit == 1) {
    output.warn(fmt::format("{} is only {:.2g} mm long; if its unit is the metre, give --unit m",
                            views.front().name, extent));
  }
  return views;
}

/// The listed pose of each input: by its name, file name or stem, or in their order.
std::vector<const ListedPose*> matched(const std::vector<ListedPose>& listed,
                                       const std::vector<std::string>& inputs) {
  std::vector<const ListedPose*> poses(inputs.size());
  std::size_t found = 0;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const fs::path path(inputs[i]);
    for (const ListedPose& pose : listed) {
      const bool same = pose.name == inputs[i] || pose.name == path.filename().string() ||
                        pose.name == path.stem().string();
      if (same && poses[i] == nullptr) {
        poses[i] = &pose;
        ++found;
      }
    }
  }
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    for (std::size_t k = i + 1; k < inputs.size(); ++k) {
      throw_if(poses[i] != nullptr && poses[i] == poses[k],
               "its pose of {} is for two views, {} and {}; name them as they are given",
               poses[i]->name, inputs[i], inputs[k]);
    }
  }
  if (found > 0) return poses;

  throw_if(listed.size() != inputs.size(), "its {} names match no view, and there are {} views",
           listed.size(), inputs.size());
  for (std::size_t i = 0; i < inputs.size(); ++i) poses[i] = &listed[i];
  return poses;
}

/// Poses from the file, in the sense in which the views meet.
std::vector<std::optional<Eigen::Isometry3d>> start_poses(const MergeFlags& flags,
                                                          const std::vector<PreparedView>& views,
                                                          Output& output) {
  const std::vector<ListedPose> listed = read_pose_list(flags.start, millimetres_of(flags.unit));
  const auto of_views = naming(flags.start, [&] { return matched(listed, flags.inputs); });

  std::vector<std::optional<Eigen::Isometry3d>> last(views.size()), first(views.size());
  bool are_matrices = true;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (of_views[i] == nullptr) continue;
    last[i] = of_views[i]->scalar_last;
    first[i] = of_views[i]->scalar_first;
    are_matrices &= of_views[i]->is_matrix;
  }

  const std::vector<PoseReading> readings = pose_readings(views, last, first, are_matrices);
  constexpr double least = 0.05;
  throw_if(
      readings.front().overlap < least,
      "{}: the views do not meet in any of {} readings of its poses (best: {}, overlap {:.0f} %); "
      "check its unit, or leave out --start",
      flags.start, readings.size(), readings.front().sense, 100 * readings.front().overlap);

  output.say("{}: read as {}: overlap {:.0f} %; the next best reading: {:.0f} %", flags.start,
             readings.front().sense, 100 * readings.front().overlap, 100 * readings[1].overlap);
  output.add("start", described("file", flags.start, "sense", readings.front().sense, "overlap",
                                readings.front().overlap, "next_overlap", readings[1].overlap));
  return readings.front().poses;
}

/// Prints how the views and pairs fit.
void tell_joint(const MergeFlags& flags, const JointAlignment& joint, Output& output) {
  for (std::size_t i = 0; i < flags.inputs.size(); ++i) {
    nlohmann::json view = described("view", flags.inputs[i], "joined", joint.poses[i].has_value());
    if (joint.poses[i]) {
      view["pose"] = app::json_of(*joint.poses[i]);
    } else {
      view["reason"] = joint.reasons[i];
    }
    output.list("views").push_back(std::move(view));
  }

  output.list("pairs");
  for (const ViewLink& link : joint.links) {
    const PairAlignment& fit = link.alignment;
    output.say(
        "{} and {}: overlap {:.0f} %, distances {:.3f} mm in the median, {:.3f} mm at 95 % "
        "(noise: {:.3f} mm)",
        flags.inputs[link.first], flags.inputs[link.second], 100 * fit.overlap, fit.median,
        fit.percentile_95, fit.noise);
    std::optional<std::string> reason;
    if (!fit.joined()) reason = fit.reason;
    output.add_to("pairs", "first", flags.inputs[link.first], "second", flags.inputs[link.second],
                  "overlap", fit.overlap, "median_mm", fit.median, "p95_mm", fit.percentile_95,
                  "rms_mm", fit.rms, "noise_mm", fit.noise, "uncertain_mm", fit.weakest_sigma,
                  "loop_error_mm", link.loop_error, "closes_loop", link.closes_loop, "reason",
                  reason);
  }
  output.list("refused");
  for (const ViewLink& link : joint.refused) {
    output.add_to("refused", "first", flags.inputs[link.first], "second", flags.inputs[link.second],
                  "refusal", name_of(link.alignment.refusal), "reason", link.alignment.reason);
  }
  for (const ViewLink& link : joint.misfits) {
    output.warn(fmt::format("{} and {} do not fit at the joint poses: {}", flags.inputs[link.first],
                            flags.inputs[link.second], link.alignment.reason));
  }

  if (joint.loop_error) {
    output.say("loop error: {:.3f} mm, {:.4f} degrees", *joint.loop_error, *joint.loop_turn);
  }
  output.add("loop_error_mm", joint.loop_error, "loop_error_deg", joint.loop_turn);
}

/// How to cut off a background that may keep views from joining; empty if none may.
std::string advice_on_background(const JointAlignment& joint) {
  bool slides = false;
  for (const ViewLink& link : joint.refused) {
    if (joint.poses[link.first] && joint.poses[link.second]) continue;
    const PairAlignment& pair = link.alignment;
    if (pair.refusal == Refusal::sees_through && pair.moved_in_part) {
      return "; --box keeps the object alone";
    }
    slides |= pair.refusal == Refusal::slides;
  }
  return slides ? "; if that is a background, --box cuts it off" : "";
}

/// Refuses views that do not fit, or with --anyway warns of them.
void refuse_left_out(const MergeFlags& flags, const JointAlignment& joint, Output& output) {
  std::string text;
  for (std::size_t i = 0; i < flags.inputs.size(); ++i) {
    if (joint.poses[i]) continue;
    if (!text.empty()) text += "; ";
    text += fmt::format("{} does not join the others: {}", flags.inputs[i], joint.reasons[i]);
  }
  if (text.empty()) return;

  text += advice_on_background(joint);

  const bool enough = joint.joined() >= 2;
  throw_if(!enough, "{}", text);
  throw_if(!flags.job.keep_refused, "{}; --anyway merges the other {} views", text, joint.joined());
  output.warn(text);
}

/// Names the view that was moved by hand.
void tell_moved(const MergeFlags& flags, const MovedView& moved, Output& output) {
  output.warn(fmt::format(
      "{} does not lie as the turntable turned it: the object was moved {} by {:.2f} degrees and "
      "{:.2f} mm; the views keep the poses found without the axis",
      flags.inputs[moved.view], moved.stays ? "before this view" : "for this view alone",
      moved.turn / degree, moved.shift));
  output.add("moved", described("view", flags.inputs[moved.view], "stays", moved.stays, "turn_deg",
                                moved.turn / degree, "shift_mm", moved.shift));
}

/// Finds the turntable's axis and steps, and lets the views lie on it.
void settle_on_turntable(const MergeFlags& flags, const std::vector<PreparedView>& views,
                         JointAlignment& joint, Output& output) {
  const std::vector<PairPose> pairs = pair_poses(joint.links);
  TurntableSettings settings;
  if (flags.turn_step) settings.step = *flags.turn_step * degree;

  TurntableFit fit = fit_turntable(views.size(), pairs, settings);
  refine_on_surfaces(views, pairs, fit, flags.turn_step.has_value());

  const Turntable& table = fit.table;
  output.say(
      "turntable: axis ({:.5f}, {:.5f}, {:.5f}), uncertain by {:.4f} degrees, through "
      "({:.3f}, {:.3f}, {:.3f}) mm, uncertain by {:.4f} mm",
      table.direction.x(), table.direction.y(), table.direction.z(), table.direction_sigma / degree,
      table.point.x(), table.point.y(), table.point.z(), table.point_sigma);

  const auto step = table.step ? std::optional(*table.step / degree) : std::nullopt;
  output.say("{}", step ? fmt::format("step {:.4f} degrees, uncertain by {:.4f}", *step,
                                      table.step_sigma / degree)
                        : std::string("the steps differ"));

  nlohmann::json angles = nlohmann::json::array();
  for (const double angle : table.angles) angles.push_back(angle / degree);
  output.add(
      "turntable",
      described("direction", table.direction, "direction_sigma_deg", table.direction_sigma / degree,
                "point_mm", table.point, "point_sigma_mm", table.point_sigma, "step_deg", step,
                "step_sigma_deg", table.step_sigma / degree, "angles_deg", angles));

  if (fit.moved) return tell_moved(flags, *fit.moved, output);
  for (std::size_t i = 0; i < views.size(); ++i) joint.poses[i] = fit.poses[i];
  output.say("distances of the pairs and loop error, measured before the turntable:");
}

/// The wanted frame, in which the first joined view's camera has the given pose; null: the model
/// stays in that camera's frame.
std::shared_ptr<const FramePose> frame_of_model(const MergeFlags& flags) {
  const auto& wanted = wanted_frame(flags.job.reconstruct);
  if (wanted == nullptr) return nullptr;
  return std::make_shared<const FramePose>(pose_from_frame(*wanted, camera_frame));
}

/// The surface of --mesh; throws Error if it has no triangles.
Surface surface_of_model(const MergeFlags& flags, const FusedModel& model, Output& output) {
  ModelMesh mesh = mesh_of(model);
  if (flags.widest_hole > 0) {
    const int filled = fill_holes(mesh, static_cast<float>(flags.widest_hole));
    output.say("filled {} of the mesh with triangles that no view saw",
               counted(static_cast<std::size_t>(filled), "hole"));
    output.add("filled_holes", filled);
  }

  Surface surface = surface_of(mesh);
  throw_if(surface.triangles.empty(),
           "{}: the model's points, {:.3g} mm apart, are too few to make a mesh of", flags.mesh,
           model.spacing);
  return surface;
}

void write_outputs(const MergeFlags& flags, const JointAlignment& joint, const FusedModel& model,
                   Output& output) {
  // Makes the surface first, so that nothing is written if it has no triangles.
  Surface surface;
  if (!flags.mesh.empty()) surface = surface_of_model(flags, model, output);

  if (!flags.output.empty()) {
    write_model(flags.output, model);
    output.add_file("model", flags.output);
  }
  if (!flags.mesh.empty()) {
    write_surface(flags.mesh, surface);
    output.add_file("mesh", flags.mesh);
  }
  if (!flags.poses.empty()) {
    std::vector<std::pair<std::string, Eigen::Isometry3d>> poses;
    for (std::size_t i = 0; i < flags.inputs.size(); ++i) {
      if (joint.poses[i]) poses.emplace_back(flags.inputs[i], *joint.poses[i]);
    }
    write_pose_list(flags.poses, poses, millimetres_of(flags.unit));
    output.add_file("poses", flags.poses);
  }
  if (!flags.report.empty()) {
    write_merge_report(flags.report, flags.inputs, joint, model);
    output.add_file("report", flags.report);
  }
}

void merge(const MergeFlags& flags, Output& output) {
  throw_if(flags.inputs.size() < 2, "merge joins two or more views; only {} is given",
           flags.inputs.size());
  if (!flags.output.empty()) require_model_ending(flags.output);
  if (!flags.mesh.empty()) require_mesh_ending(flags.mesh);
  if (std::ranges::all_of(flags.inputs, is_cloud_file)) {
    flags.of_scans.refuse_for_cloud(flags.inputs.front());
  }
  const auto frame = frame_of_model(flags);
  Stopwatch watch;

  // 1. The views.
  std::vector<View> read = read_views(flags, output);
  const float cell = keypoint_cell(read);
  std::vector<PreparedView> views;
  for (View& view : read) views.emplace_back(std::move(view), cell);

  // 2. Their poses.
  JointSettings settings;
  if (!flags.start.empty()) settings.starts = start_poses(flags, views, output);
  settings.progress = progress_of("joining");
  JointAlignment joint = join_views(views, settings);
  settings.progress = nullptr;
  if (flags.turntable && joint.joined() == views.size()) {
    settle_on_turntable(flags, views, joint, output);
  } else if (flags.turntable) {
    output.warn("skipped the turntable: not all views join");
  }

  for (auto& pose : joint.poses) {
    if (pose && frame) pose = frame->transform * *pose;
  }
  tell_joint(flags, joint, output);
  refuse_left_out(flags, joint, output);

  // 3. The model.
  output.tell_wait("fusing the views");
  std::vector<const View*> sources;
  for (const PreparedView& view : views) sources.push_back(&view.view());
  FusedModel model = fuse(sources, joint.poses, static_cast<float>(flags.spacing));
  model.frame = frame;

  const ModelQuality quality = quality_of(model);
  const double seconds = watch.lap();
  output.say("{} of {} views, {} points {:.3g} mm apart, sigma {:.3f} mm in the median; {:.1f} s",
             joint.joined(), views.size(), model.points.size(), model.spacing, quality.median_sigma,
             seconds);
  output.add("joined", joint.joined(), "points", model.points.size(), "spacing_mm", model.spacing,
             "median_sigma_mm", quality.median_sigma, "median_disagreement_mm",
             quality.median_disagreement, "seconds", seconds);

  // 4. The files.
  write_outputs(flags, joint, model, output);
}

}  // namespace

void add_merge(const Commands& program) {
  const auto [command, flags] = program.add(
      merge, "merge", "join clouds or scans of one object, or of one scene, to one model");

  required(command.add_file("views", flags.inputs,
                            "two or more clouds (.ply, .pcd, .xyz, ...) or scan folders, in the "
                            "order in which they were taken"));
  command.add_output("-o,--output", flags.output,
                     "write the model's points: .ply with standard deviation, number of views and "
                     "disagreement, .pcd or .xyz");
  command.add_output("--mesh", flags.mesh, "write the model's surface: .ply, .stl, .obj or .glb");
  command.add_output("--poses", flags.poses, "write each view's pose in the model as text");
  command.add_output("--report", flags.report, "write a page with pairs, residuals and pictures");
  command.add_file(
      "--start", flags.start,
      "poses to start from: a line for each view with its name, x y z and a quaternion, "
      "or a matrix; optional");
  command.add("--unit", flags.unit, "unit of the clouds, --start and --poses: mm, cm or m");
  const auto zero_or_more = [](const std::string& flag, const std::string& zero) {
    return [=](const std::string& text) {
      const double value = std::strtod(text.c_str(), nullptr);
      require_in_range(value >= 0, flag, value, "0 (" + zero + ") or more");
      return std::string();
    };
  };
  command.add("--spacing", flags.spacing, "distance of the model's points, mm; 0: as in the views")
      ->check(zero_or_more("--spacing", "as the views"));
  command
      .add("--fill-holes", flags.widest_hole,
           "with --mesh: fill holes up to this width, mm, with triangles that no view saw; 0: none")
      ->check(zero_or_more("--fill-holes", "none"))
      ->needs("--mesh");

  command.add("--turntable", flags.turntable,
              "the views were taken in order while the object turned about one axis: find the axis "
              "and the angles, and name a view that was moved by hand");
  command
      .add("--turn-step", flags.turn_step, "with --turntable: degrees from view to view, if known")
      ->needs("--turntable");

  const std::size_t before = command.app.get_options().size();
  add_cloud_flags(command.app, flags.changes, flags.job);
  flags.of_scans = flags_of_scans(command.app, before, {"--anyway", "--box", "--to-frame"});
  command.app.get_option("--anyway")
      ->description(
          "merge the other views if some do not join, and continue with scans that the "
          "check refuses");
  command.app.get_option("--to-frame")
      ->description(
          "pose file of the first view's camera: the model is in its frame, and so is --box of "
          "each view");
  command.common({"--output", "--mesh", "--poses", "--report", "--start", "--unit"});
  command.examples(
      {"merge view1.ply view2.ply view3.ply -o model.ply --report merge.html",
       "merge scan1 scan2 --mesh model.stl --poses poses.txt"},
      "Finds the poses by itself. Refuses views that fit in more than one way, such as "
      "planes and spheres. The model is in the frame of the first view that joins, or of "
      "--to-frame.");
}

}  // namespace slipstream::app
