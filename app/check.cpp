#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/commands.h"
#include "app/scan_flags.h"
#include "base/numbers.h"
#include "slipstream/measure.h"

namespace slipstream::app {
namespace {

struct CheckFlags {
  std::vector<std::string> folders;
  ScanChanges changes;
  ScanJobSettings job;
};

/// Prints the scale of the scan's scanner, and how it fits the guard, if any.
void tell_scanner(const std::string& folder, const Scanner& scanner, const ScanCheck& result,
                  Output& output) {
  const double baseline = scanner.translation.norm(), depth = result.checked.median_depth;
  output.say("{}: baseline {:.4g} mm, median depth of the pixels checked {:.4g} mm", folder,
             baseline, depth);
  if (result.guard) tell_guard(*result.guard, folder + ": ", output);
  describe(output.list("scans").back(), "baseline_mm", baseline, "median_depth_mm", depth, "guard",
           result.guard);
}

void check(const CheckFlags& flags, Output& output) {
  output.document["scans"] = nlohmann::json::array();
  Progress progress("scans", flags.folders.size());
  for (const std::string& folder : flags.folders) {
    Scan scan = load_checkable(folder, flags.changes, true, output);
    const ScanCheck result = check(scan, flags.job);
    const std::vector<Finding>& findings = result.checked.findings;
    if (any_wrong(findings)) output.exit_code = 2;
    output.add_to("scans", "scan", folder, "findings", findings);

    // The bar goes, so that the scan's lines do not overwrite it.
    progress.finish();
    if (findings.empty()) output.say("{}: OK: no problems found", folder);
    for (const Finding& finding : findings) {
      output.say("{}: {}: {}", folder, finding.severity == Severity::wrong ? "wrong" : "doubtful",
                 text_of(finding));
    }

    if (scan.scanner) {
      tell_scanner(folder, *scan.scanner, result, output);
    } else if (!scan.further_cameras.empty()) {
      output.say("{}: two cameras, no projector: the calibration is not checked", folder);
    }

    progress.advance();
  }
}

struct MeasureFlags {
  std::string path;
  ScanChanges changes;
  ScanJobSettings job;
  std::vector<std::string> points, planes, spheres;
  std::vector<std::pair<std::string, std::string>> distances;
};

/// The measured cloud and where to print results.
struct Measuring {
  const StoredCloud& stored;  ///< in the camera's frame
  const FramePose* frame;     ///< of the results; null: the camera's
  const std::string& path;
  Output& output;

  /// A place or a direction in the frame of the results.
  [[nodiscard]] Eigen::Vector3d place(const Eigen::Vector3d& position) const {
    return frame == nullptr ? position : Eigen::Vector3d(frame->transform * position);
  }
  [[nodiscard]] Eigen::Vector3d direction(const Eigen::Vector3d& vector) const {
    return frame == nullptr ? vector : Eigen::Vector3d(frame->transform.linear() * vector);
  }

  /// Noise moves a point along its ray, so its standard deviations turn with the ray.
  [[nodiscard]] std::optional<Eigen::Vector3d> sigma(const MeasuredPoint& point) const {
    if (!point.sigma || frame == nullptr) return point.sigma;
    const Eigen::Vector3d along = point.sigma->norm() * point.position.normalized();
    return Eigen::Vector3d(direction(along).cwiseAbs());
  }

  void require_pixels(const std::string& value) const {
    throw_if(!stored.organised,
             "{}: its points are not organised by pixel, as '{}' requires; measure the scan or an "
             "organised .pcd, or fit --plane or --sphere to all points: all",
             path, value);
  }
};

MeasuredPoint point_of(const Measuring& in, const std::string& text) {
  const std::vector<int> numbers = numbers_in<int>(text, ',');
  throw_if(numbers.size() != 2, "'{}' is not a pixel; give column and row, e.g. 320,240", text);
  in.require_pixels(text);

  const int column = numbers[0], row = numbers[1];
  const Cloud& cloud = in.stored.cloud;
  if (const auto point = point_at(cloud, uncertainty_of(in.stored), column, row)) return *point;

  const bool inside =
      column >= 0 && row >= 0 && column < cloud.size().width && row < cloud.size().height;
  throw Error(
      inside ? fmt::format("pixel {} has no point: {}", text, name_of(cloud.validity(column, row)))
             : fmt::format("pixel {} is outside the picture of {}", text, text_of(cloud.size())));
}

std::vector<MeasuredPoint> points_of(const Measuring& in, const std::string& text) {
  const Size size = in.stored.cloud.size();
  const std::optional<Rectangle> rectangle =
      text == "all" ? Rectangle{0, 0, size.width, size.height} : rectangle_of_text(text);
  throw_if(!rectangle.has_value(),
           "'{}' is not a rectangle; give width x height + x + y, e.g. 200x100+320+240, or all",
           text);

  if (text != "all") in.require_pixels(text);
  return points_in(in.stored.cloud, uncertainty_of(in.stored), *rectangle);
}

std::string coordinates_of(const Eigen::Vector3d& vector) {
  return fmt::format("{:.3f}, {:.3f}, {:.3f}", vector.x(), vector.y(), vector.z());
}

void measure_point(const std::string& pixel, const Measuring& in) {
  const MeasuredPoint point = point_of(in, pixel);
  const Eigen::Vector3d position = in.place(point.position);
  const std::optional<Eigen::Vector3d> sigma = in.sigma(point);
  in.output.add_to("points", "pixel", pixel, "position_mm", position, "sigma_mm", sigma);
  in.output.say("point {}: {} mm{}", pixel, coordinates_of(position),
                sigma ? fmt::format(", sigma {} mm", coordinates_of(*sigma)) : "");
}

void measure_distance(const std::pair<std::string, std::string>& pixels, const Measuring& in) {
  const Distance apart = distance(point_of(in, pixels.first), point_of(in, pixels.second));
  const auto& [from, to] = pixels;
  in.output.add_to("distances", "from", from, "to", to, "length_mm", apart.length, "sigma_mm",
                   apart.sigma);
  in.output.say("distance {} to {}: {:.3f} mm{}", from, to, apart.length,
                apart.sigma ? fmt::format(", sigma {:.3f} mm", *apart.sigma) : "");
}

/// Prints the residuals of a fitted shape, and adds them to its JSON object.
void tell_fit(const char* list, nlohmann::json entry, const Residuals& residuals, Output& output) {
  entry.update(described("rms_mm", residuals.rms, "largest_mm", residuals.largest, "points",
                         residuals.points, "outliers", residuals.outliers, "noise_mm",
                         residuals.noise));

  output.list(list).push_back(std::move(entry));
  output.say("  residuals of {} points: rms {:.4f} mm{}, largest {:.4f} mm; {} outliers ignored",
             residuals.points, residuals.rms,
             residuals.noise ? fmt::format(" (noise alone: {:.4f})", *residuals.noise) : "",
             residuals.largest, residuals.outliers);
}

void measure_plane(const std::string& rectangle, const Measuring& in) {
  const FittedPlane plane = fit_plane(points_of(in, rectangle));
  const Eigen::Vector3d centre = in.place(plane.centre), normal = in.direction(plane.normal);
  in.output.say("plane in {}: through {} mm, normal {}", rectangle, coordinates_of(centre),
                coordinates_of(normal));
  tell_fit("planes", described("rectangle", rectangle, "centre_mm", centre, "normal", normal),
           plane.residuals, in.output);
}

void measure_sphere(const std::string& rectangle, const Measuring& in) {
  const FittedSphere sphere = fit_sphere(points_of(in, rectangle));
  const Eigen::Vector3d centre = in.place(sphere.centre);
  in.output.say("sphere in {}: radius {:.4f} mm, sigma {:.4f} mm, centre {} mm", rectangle,
                sphere.radius, sphere.radius_sigma, coordinates_of(centre));
  tell_fit("spheres",
           described("rectangle", rectangle, "centre_mm", centre, "radius_mm", sphere.radius,
                     "radius_sigma_mm", sphere.radius_sigma),
           sphere.residuals, in.output);
}

void measure(const MeasureFlags& flags, Output& output) {
  throw_if(flags.points.empty() && flags.distances.empty() && flags.planes.empty() &&
               flags.spheres.empty(),
           "nothing to measure; give --point, --distance, --plane or --sphere");

  // A cloud file is measured as it is; a scan is reconstructed first.
  output.document["input"] = flags.path;
  output.tell_wait(flags.path + ": reading");
  StoredCloud stored = is_cloud_file(flags.path)
                           ? loaded_cloud(flags.path, output)
                           : organised_cloud(flags.path, flags.changes, flags.job, output);

  // Shapes are fitted as the camera sees them; results are in the file's frame or the wanted one.
  std::shared_ptr<const FramePose> frame = stored.cloud.frame;
  const std::shared_ptr<const FramePose>& wanted = wanted_frame(flags.job.reconstruct);
  if (wanted) frame = frame_after(frame, *wanted);
  move_to_camera(stored.cloud, stored.uncertainty ? &*stored.uncertainty : nullptr);
  output.document["frame"] = frame ? std::string_view(frame->to) : camera_frame;
  if (frame) output.say("coordinates in the frame {}", frame->to);

  const Measuring in{stored, frame.get(), flags.path, output};
  for (const auto& pixel : flags.points) measure_point(pixel, in);
  for (const auto& pixels : flags.distances) measure_distance(pixels, in);
  for (const auto& rectangle : flags.planes) measure_plane(rectangle, in);
  for (const auto& rectangle : flags.spheres) measure_sphere(rectangle, in);
}

}  // namespace

void add_measure(const Commands& program) {
  const auto [command, flags] = program.add(
      measure, "measure", "measure points, distances, planes and spheres in a cloud, mm");

  required(command.add_file(
      "input", flags.path,
      "a scan folder, a recording or a cloud; pixels need an organised one, .pcd"));

  const FlagGroup group{command.app, "What to measure (each may be repeated)"};
  group.add("--point", flags.points, "the point at pixel column,row, e.g. 320,240");
  group.add("--distance", flags.distances,
            "distance between the points of two pixels, e.g. 320,240 400,250");
  group.add("--plane", flags.planes,
            "fit to the points in a pixel rectangle, width x height + x + y, e.g. "
            "200x100+320+240, or to all");
  group.add("--sphere", flags.spheres, "fit to the points in a pixel rectangle, as for --plane");

  add_cloud_flags(command.app, flags.changes, flags.job);
  command.common({"--point", "--distance", "--plane", "--sphere", "--scanner",
                  "--minimum-modulation", "--largest-sigma", "--raw"});
  command.examples({"measure scan --point 320,240 --distance 100,200 500,210",
                    "measure cloud.pcd --plane 200x100+320+240 --json",
                    "measure cloud.ply --sphere all"});
}

void add_check(const Commands& program) {
  const auto [command, flags] = program.add(
      check, "check", "check that a scan's frames fit its patterns, its scanner and each other");

  required(command.add_file("folders", flags.folders,
                            "scan folders (pictures, and scan.yaml or flags) or recordings"));
  command.add("--minimum-modulation", flags.job.reconstruct.minimum_modulation,
              "minimum modulation of a valid pixel, grey levels of 255 at any bit depth");

  add_scan_input_flags(command.app, flags.changes, flags.job);
  command.common({"--scanner", "--strategy", "--steps", "--high", "--low", "--axis", "--projector",
                  "--order"});
  command.examples(
      {"check scan", "check frames --strategy pmp --steps 4"},
      "Without a scanner fewer checks are possible. Exit code 2: reconstruct would reject a scan.");
}

}  // namespace slipstream::app
