#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/ranges.h>

#include "app/board_flags.h"
#include "app/commands.h"
#include "app/frame.h"
#include "app/scan_flags.h"
#include "base/numbers.h"
#include "base/statistics.h"
#include "calibrate/board_corners.h"
#include "calibrate/first_guess.h"
#include "calibrate/marker_pose.h"
#include "cloud/plane_frame.h"
#include "geometry/point_fit.h"
#include "io/file.h"
#include "io/image_file.h"
#include "slipstream/measure.h"
#include "slipstream/scan_files.h"

namespace slipstream::app {
namespace {

constexpr const char* input_help = "a scan folder, a recording or an organised cloud, .pcd";

/// Flags of every command that finds a frame.
struct FoundFrameFlags {
  std::string input, name;
  ScanChanges changes;
  PoseOutputFlags output;
};

struct PointsFlags : FoundFrameFlags {
  std::string pairs;
  std::vector<std::pair<std::string, std::string>> picks;
  ScanJobSettings job;
};

struct PlanesFlags : FoundFrameFlags {
  std::vector<std::string> planes;
  ScanJobSettings job;
};

struct BoardPoseFlags : FoundFrameFlags {
  BoardFlags board;
};

struct MarkerPoseFlags : FoundFrameFlags {
  Markers markers = Markers::april_36h11;
  double side = 0;  ///< mm
  std::optional<int> number;
};

/// Prints and writes the pose, from the camera to the new frame.
void put_found(const Eigen::Isometry3d& pose, const FoundFrameFlags& flags, Output& output) {
  const std::string& name = flags.name;
  require_frame_name(name);
  throw_if(name == camera_frame, "--name {}: this is the name of the camera's frame", name);
  put_pose({std::string(camera_frame), name, pose}, flags.output, output);
}

/// Points of the camera's frame and their partners in the new one, each with its name.
struct PointPairs {
  std::vector<Eigen::Vector3d> points{}, partners{};
  std::vector<std::string> names{};
};

/// Adds the lines of a file: x,y,z of the camera, then of the new frame, mm.
void read_pairs(const std::string& file, PointPairs& pairs) {
  const std::string text = read_text(file);
  std::string_view rest = text;

  for (int number = 1; !rest.empty(); ++number) {
    std::string line(take_until(rest, '\n'));
    std::erase_if(line, [](char c) { return c == ' ' || c == '\t'; });
    if (line.empty() || line[0] == '#') continue;

    const std::vector<double> numbers = numbers_in<double>(line, ',');
    const bool finite = std::ranges::all_of(numbers, [](double n) { return std::isfinite(n); });
    throw_if(numbers.size() != 6 || !finite,
             "{}: line {}: expected x,y,z in the camera's frame and x,y,z in the other, mm", file,
             number);
    pairs.points.emplace_back(numbers.data());
    pairs.partners.emplace_back(numbers.data() + 3);
    pairs.names.push_back(fmt::format("line {}", number));
  }
}

/// Adds the picked pixels of a cloud.
void pick_points(const PointsFlags& flags, PointPairs& pairs, Output& output) {
  throw_if(flags.input.empty(), "--pick needs the scan or cloud whose pixels are picked");
  const StoredCloud stored = organised_cloud(flags.input, flags.changes, flags.job, output);

  for (const auto& [pixel, place] : flags.picks) {
    const std::vector<int> numbers = numbers_in<int>(pixel, ',');
    throw_if(numbers.size() != 2, "--pick '{}': expected column,row of a pixel, e.g. 320,240",
             pixel);
    const auto point = point_at(stored.cloud, nullptr, numbers[0], numbers[1]);
    throw_if(!point, "--pick {}: this pixel has no point; pick another", pixel);

    pairs.points.push_back(point->position);
    pairs.partners.push_back(place_from(place, "--pick " + pixel));
    pairs.names.push_back("pixel " + pixel);
  }
}

/// Throws Error if the points and their partners are not one shape. A wrong order or unit leaves
/// residuals of about the distances between the points; a mistyped digit leaves less.
void require_one_shape(const PointPairs& pairs, const PointFit& fit) {
  constexpr double most = 0.1;  // of the points' distances from their mean

  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : pairs.points) mean += point;
  mean /= static_cast<double>(pairs.points.size());

  Squares distances;
  for (const Eigen::Vector3d& point : pairs.points) distances.add((point - mean).squaredNorm());
  const auto worst = std::ranges::max_element(fit.residuals) - fit.residuals.begin();
  throw_if(fit.rms > most * distances.rms(),
           "the points do not fit their places in the frame: residuals of {:.3g} mm RMS, the "
           "largest at {}, where the points are {:.3g} mm from their mean; check their order, unit "
           "and signs",
           fit.rms, pairs.names[static_cast<std::size_t>(worst)], distances.rms());
}

void find_by_points(const PointsFlags& flags, Output& output) {
  throw_if(flags.pairs.empty() && flags.picks.empty(),
           "no points; give --pairs FILE, or three --pick or more");
  throw_if(flags.picks.empty() && !flags.input.empty(),
           "{}: give --pick with its pixels; --pairs alone needs no scan", flags.input);

  PointPairs pairs;
  if (!flags.pairs.empty()) read_pairs(flags.pairs, pairs);
  if (!flags.picks.empty()) pick_points(flags, pairs, output);
  const PointFit fit = fit_points(pairs.points, pairs.partners);
  require_one_shape(pairs, fit);

  put_found(fit.pose, flags, output);
  output.say("residuals of {} points: RMS {:.3f} mm", pairs.points.size(), fit.rms);
  for (std::size_t i = 0; i < pairs.points.size(); ++i) {
    output.say("  {}: {:.3f} mm", pairs.names[i], fit.residuals[i]);
  }
  if (pairs.points.size() == 3) {
    output.say("  three points hardly check each other; more points show errors");
  }
  output.add("rms_mm", fit.rms, "residuals_mm", fit.residuals);
}

void find_by_planes(const PlanesFlags& flags, Output& output) {
  throw_if(flags.planes.size() != 3,
           "{} planes; give three: the first sets z, the second y, the third the origin along x",
           flags.planes.size());
  const StoredCloud stored = organised_cloud(flags.input, flags.changes, flags.job, output);

  std::array<FittedPlane, 3> planes;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const std::string& plane = flags.planes[i];
    const Rectangle region = region_from(plane, "--plane");
    planes[i] = naming("--plane " + plane,
                       [&] { return fit_plane(points_in(stored.cloud, nullptr, region)); });
  }
  const PlaneFrame found = frame_of_planes(planes);

  put_found(found.pose, flags, output);
  for (std::size_t i = 0; i < planes.size(); ++i) {
    output.say("plane {}: residuals of {} points, RMS {:.4f} mm", i + 1, planes[i].residuals.points,
               planes[i].residuals.rms);
  }
  const auto& [first, second, third] = found.off_square;
  output.say("off a right angle: planes 1 and 2 {:+.3f}, 1 and 3 {:+.3f}, 2 and 3 {:+.3f} degrees",
             first / degree, second / degree, third / degree);
  output.add("off_square_deg", std::array{first / degree, second / degree, third / degree},
             "rms_mm",
             as_json(planes, [](const FittedPlane& plane) { return plane.residuals.rms; }));
}

/// The scene of a scan without fringes, and the lens that took it.
struct SeenPicture {
  FringeFreePictures pictures;
  Lens lens;
};

SeenPicture picture_in(const std::string& input, const ScanChanges& changes, Output& output) {
  // A folder of a board's pose has a scan along each axis; both show the board.
  std::string path = input;
  for (const char* const scan : {"x", "x.slip"}) {
    const fs::path along_x = fs::path(input) / scan;
    if (fs::is_directory(input) && fs::exists(along_x)) path = along_x.string();
  }

  const Scan scan = load_checkable(path, changes, false, output);
  throw_if(!scan.scanner || !has_geometry(*scan.scanner),
           "{}: no scanner is known, whose camera took it; name its file with --scanner", input);
  const Lens& lens = scan.scanner->camera;
  throw_if(lens.size != scan.frames.size(), "{}: pictures of {}, but the scanner's camera has {}",
           input, text_of(scan.frames.size()), text_of(lens.size));
  return {fringe_free_pictures(scan.frames, scan.frames), lens};
}

void find_by_board(const BoardPoseFlags& flags, Output& output) {
  const CalibrationBoard board = board_from(flags.board);
  const SeenPicture seen = picture_in(flags.input, flags.changes, output);

  // 1. The corners.
  const std::optional<BoardCorners> corners = find_board(board, seen.pictures);
  throw_if(!corners || corners->places.size() < 6,
           "{}: no {} of {}x{} corners is visible; likely wrong --board or --corners, or a picture "
           "that is dark, overexposed or out of focus",
           flags.input, name_of(board.kind), board.columns, board.rows);

  // 2. The board's pose, and how well its corners lie where they should.
  const BoardPlaces printed = printed_places(board);
  BoardView view;
  view.name = flags.input;
  view.places = corners->places;
  view.camera = corners->pixels;
  const Eigen::Isometry3d pose = pose_before_camera(view, seen.lens, printed);

  Squares errors;
  for (std::size_t i = 0; i < view.places.size(); ++i) {
    const Eigen::Vector3d place = pose * printed[static_cast<std::size_t>(view.places[i])];
    errors.add((project(seen.lens, place) - view.camera[i]).squaredNorm());
  }
  const double rms = errors.rms();

  put_found(pose.inverse(), flags, output);
  output.say("board: {} corners found by the {}, RMS {:.3f} pixels", view.places.size(),
             corners->detector, rms);
  output.say("  its x runs along a row, y from row to row, z away from the camera");
  output.add("corners", view.places.size(), "rms_px", rms);
}

/// The marker with the number of the flags, or the only one.
SeenMarker marker_in(const Image<float>& picture, const MarkerPoseFlags& flags) {
  std::vector<SeenMarker> seen = find_markers(flags.markers, picture);
  if (flags.number) {
    std::erase_if(seen, [&](const SeenMarker& one) { return one.number != *flags.number; });
  }
  throw_if(seen.empty(),
           "{}: no marker{} of {} is visible; likely another --family, no white margin, or a "
           "picture that is dark or out of focus",
           flags.input, flags.number ? fmt::format(" {}", *flags.number) : "",
           name_of(flags.markers));

  std::vector<int> numbers;
  for (const SeenMarker& one : seen) numbers.push_back(one.number);
  throw_if(seen.size() > 1, "{}: {} markers are visible, {}; {}", flags.input, seen.size(),
           fmt::join(numbers, ", "),
           flags.number ? "cover all but one" : "choose one with --number");
  return seen.front();
}

void find_by_marker(const MarkerPoseFlags& flags, Output& output) {
  require_in_range(flags.side > 0, "--side", flags.side, "more than 0 mm");
  const SeenPicture seen = picture_in(flags.input, flags.changes, output);
  const Image<float>& picture = seen.pictures.mean;
  const SeenMarker marker = marker_in(picture, flags);
  const MarkerPose found = naming(fmt::format("{}: marker {}", flags.input, marker.number), [&] {
    return marker_pose(flags.markers, marker, flags.side, picture, seen.lens);
  });

  put_found(found.pose.inverse(), flags, output);
  const Eigen::Vector3d& off = found.translation_deviation;
  const Eigen::Vector3d turn = found.rotation_deviation / degree;
  output.say("marker {}: {:.3f} pixels RMS along its sides", marker.number, found.rms);
  output.say("  standard deviation: x {:.3f}, y {:.3f}, z {:.3f} mm in the camera's frame;",
             off.x(), off.y(), off.z());
  output.say("  about its own x {:.3f}, y {:.3f}, z {:.3f} degrees", turn.x(), turn.y(), turn.z());
  output.say("  its x runs right and y down as printed, z away from the camera");
  output.add("marker", marker.number, "rms_px", found.rms, "translation_deviation_mm", off,
             "rotation_deviation_degrees", turn);
}

/// Adds --name and the flags of the pose; `usual`: the frame's name by default.
void add_found_flags(const FlagGroup& group, const char* usual, FoundFrameFlags& flags) {
  flags.name = usual;
  group.add("--name", flags.name, "name of the new frame");
  add_pose_output_flags(group, flags.output);
}

}  // namespace

void add_found_frames(const Commands& frame) {
  // 1. slipstream frame points
  const auto [points, by_points] =
      frame.add(find_by_points, "points", "find a frame from three points or more");
  points.add_file("input", by_points.input, input_help);
  points.add("--pick", by_points.picks,
             "pixel column,row and its place x,y,z in the new frame, mm; repeat it: 320,240 "
             "100,0,0");
  points.add_file("--pairs", by_points.pairs,
                  "lines of six numbers, mm: x,y,z in the camera's frame, then in the new: .csv");
  add_found_flags(points, "part", by_points);
  add_cloud_flags(points.app, by_points.changes, by_points.job);
  points.examples(
      {"frame points plate --pick 240,160 0,0,0 --pick 400,160 126.5,0,0 --pick "
       "240,320 17.1,122.4,0 --name plate -o plate.yaml"});

  // 2. slipstream frame planes
  const auto [planes, by_planes] =
      frame.add(find_by_planes, "planes", "find a frame from three planes, as of a box's corner");
  required(planes.add_file("input", by_planes.input, input_help));
  planes.add("--plane", by_planes.planes,
             "pixel rectangle on a plane, width x height + x + y; three: the first sets z, towards "
             "the camera, the second y, the third the origin");
  add_found_flags(planes, "part", by_planes);
  add_cloud_flags(planes.app, by_planes.changes, by_planes.job);

  // 3. slipstream frame board
  const auto [board, by_board] =
      frame.add(find_by_board, "board", "find the frame of a calibration board in view");
  required(board.add_file("input", by_board.input,
                          "a scan folder or a recording of the board, or a pose's folder"));
  add_board_flags(board.app, by_board.board);
  add_found_flags(board, "board", by_board);
  add_input_flags(board.app, by_board.changes);
  board.examples(
      {"frame board boards/board01 --corners 13x9 --spacing 15 --scanner scanner.yaml "
       "-o board.yaml"});

  // 4. slipstream frame marker
  const auto [marker, by_marker] =
      frame.add(find_by_marker, "marker", "find the frame of an AprilTag or ArUco marker in view");
  required(marker.add_file("input", by_marker.input, "a scan folder or a recording of the marker"));
  required(marker.add("--side", by_marker.side, "side of the marker's black square, mm"));
  marker.add("--number", by_marker.number, "the marker's number, if several are in view");
  marker.add_named("--family", by_marker.markers, markers_named, name_of(by_marker.markers),
                   "36h11, 36h10, 25h9 or 16h5 of AprilTag; 4x4, 5x5, 6x6 or 7x7 of ArUco");
  add_found_flags(marker, "marker", by_marker);
  add_input_flags(marker.app, by_marker.changes);
  marker.examples(
      {"frame marker boards/board01 --family 4x4 --number 2 --side 30 --scanner scanner.yaml"});
}

}  // namespace slipstream::app
