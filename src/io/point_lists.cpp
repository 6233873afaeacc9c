#include "io/point_lists.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/point_arrays.h"
#include "io/scan_pictures.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

enum class PointKind { board, camera, projector };
constexpr std::array kind_names{"board", "camera", "projector"};

/// The meaning of a column of a table.
struct ColumnUse {
  std::optional<PointKind> kind{};  ///< nullopt: the pose, or something else
  int axis = -1;                    ///< 0: x, u or column; 1: y, v or row; 2: z
  bool is_pose = false;
};

using Words = std::vector<std::string>;

bool has_word(const Words& words, std::initializer_list<std::string_view> wanted) {
  return std::ranges::any_of(
      words, [&](const std::string& word) { return std::ranges::count(wanted, word) > 0; });
}

bool begins_a_word(const Words& words, std::initializer_list<std::string_view> beginnings) {
  return std::ranges::any_of(words, [&](const std::string& word) {
    return std::ranges::any_of(beginnings, [&](auto begin) { return word.starts_with(begin); });
  });
}

/// The kind that a name says; the projector first, since its points are pixels of an image, too.
std::optional<PointKind> kind_in(const Words& words) {
  if (begins_a_word(words, {"proj", "prj"}) || has_word(words, {"p", "pro", "dmd"})) {
    return PointKind::projector;
  }
  if (begins_a_word(words, {"obj", "board", "world", "target", "model"})) return PointKind::board;
  if (begins_a_word(words, {"cam", "im"}) || has_word(words, {"c"})) return PointKind::camera;
  return std::nullopt;
}

/// The meaning of a column, from its name. `usual`: the kind of an array that has only one.
ColumnUse use_of(const std::string& name, std::optional<PointKind> usual) {
  Words words = words_and_numbers(name);
  if (has_word(words, {"pose", "view", "frame", "picture", "board"}) && words.size() == 1) {
    return {.is_pose = true};
  }
  if (has_word(words, {"pose", "view"})) return {.is_pose = true};

  // An axis and a device in one word, such as up or xc.
  for (const std::string_view device : {"c", "p", "w"}) {
    for (const std::string_view axis : {"u", "v", "x", "y", "z"}) {
      const std::string before = fmt::format("{}{}", axis, device);
      const std::string after = fmt::format("{}{}", device, axis);
      if (words.size() != 1 || (words[0] != before && words[0] != after)) continue;
      words = {device == "w" ? "world" : std::string(device), std::string(axis)};
    }
  }

  ColumnUse use{.kind = kind_in(words)};
  if (has_word(words, {"x", "u", "col", "column"})) use.axis = 0;
  if (has_word(words, {"y", "v", "row"})) use.axis = 1;
  if (has_word(words, {"z"})) use.axis = 2;

  if (!use.kind) use.kind = usual;
  if (!use.kind && has_word(words, {"x", "y", "z"})) use.kind = PointKind::board;
  if (!use.kind && has_word(words, {"u", "v"})) use.kind = PointKind::camera;
  return use;
}

/// Whether the column has the same number in all rows.
bool is_constant(const PointArray& array, int column) {
  for (int row = 1; row < array.rows(); ++row) {
    if (array.at(row, column) != array.at(0, column)) return false;
  }
  return true;
}

/// The uses of the columns of a whole table without names, by their number.
std::vector<ColumnUse> usual_uses(const PointArray& array) {
  using enum PointKind;
  std::vector<ColumnUse> uses{{board, 0},  {board, 1},     {board, 2},    {camera, 0},
                              {camera, 1}, {projector, 0}, {projector, 1}};
  const ColumnUse pose{.is_pose = true};

  // Seven columns may begin with a pose or have z, which is the same on a whole board.
  const bool has_pose = array.columns == 8 ||
                        (array.columns == 7 && (!array.poses.empty() || !is_constant(array, 2)));
  const bool has_z = array.columns == 8 || (array.columns == 7 && !has_pose);
  if (array.columns < 6 || array.columns > 8) return {};

  if (!has_z) uses.erase(uses.begin() + 2);
  if (has_pose) uses.insert(uses.begin(), pose);
  return uses;
}

/// The uses of an array's columns; empty for arrays of other things.
std::vector<ColumnUse> uses_of(const PointArray& array) {
  const Words words = words_and_numbers(array.name);
  if (has_word(words, {"matrix", "mtx", "k", "kc", "dist", "distortion", "r", "t", "rvecs", "tvecs",
                       "intrinsic", "size", "shape"})) {
    return {};
  }

  const auto kind = kind_in(words);
  std::vector<ColumnUse> uses;

  if (!array.names.empty()) {
    for (const std::string& name : array.names) uses.push_back(use_of(name, kind));
    return uses;
  }
  if (array.columns >= 6) return usual_uses(array);
  if (!kind) return {};

  // One kind alone, perhaps behind a pose.
  const int most = *kind == PointKind::board ? 3 : 2;
  if (array.columns > most + 1 || array.columns < 2) return {};
  if (array.columns > most) uses.push_back({.is_pose = true});
  for (int axis = 0; axis < std::min(most, array.columns); ++axis) uses.push_back({*kind, axis});
  return uses;
}

/// The points of one kind of one pose: rows of x, y and z.
using KindPoints = std::vector<Eigen::Vector3d>;

/// The kinds of a pose.
using PoseKinds = std::map<PointKind, KindPoints>;

/// All points, by pose; "" is the pose of arrays that name none.
struct FoundPoses {
  std::vector<std::string> order{};  ///< as they first appeared
  std::map<std::string, PoseKinds> poses{};

  PoseKinds& operator[](const std::string& pose) {
    if (!poses.contains(pose)) order.push_back(pose);
    return poses[pose];
  }
};

/// The last number in an array's name, which says its pose; "" without one.
std::string pose_in_name(const std::string& name) {
  const Words words = words_and_numbers(name);
  for (auto word = words.rbegin(); word != words.rend(); ++word) {
    if (const auto number = number_in<int>(*word)) return std::to_string(*number);
  }
  return "";
}

/// The name of the pose of a row.
std::string pose_of_row(const PointArray& array, const std::vector<ColumnUse>& uses, int row) {
  if (!array.poses.empty()) return array.poses[row];
  if (array.layers > 1) return std::to_string(row / (array.rows() / array.layers) + 1);

  const auto column = std::ranges::find(uses, true, &ColumnUse::is_pose);
  if (column == uses.end()) return pose_in_name(array.name);
  return fmt::format("{}", array.at(row, static_cast<int>(column - uses.begin())));
}

/// Throws Error unless every kind of the columns has x and y once.
void require_both_axes(const std::vector<ColumnUse>& uses, const std::string& name) {
  for (const PointKind kind : {PointKind::board, PointKind::camera, PointKind::projector}) {
    std::array<int, 3> count{};
    for (const ColumnUse& use : uses) {
      if (use.kind == kind && use.axis >= 0) ++count.at(use.axis);
    }
    throw_if(count[0] != count[1] || count[0] > 1 || count[2] > 1,
             "{}: its columns do not give x and y of the {} once; name them board_x, board_y, "
             "camera_u, camera_v, projector_u and projector_v",
             name, kind_names.at(static_cast<std::size_t>(kind)));
  }
}

void add_array(const PointArray& array, FoundPoses& found) {
  const std::vector<ColumnUse> uses = uses_of(array);
  require_both_axes(uses, array.name);

  for (int row = 0; row < array.rows(); ++row) {
    PoseKinds& pose = found[pose_of_row(array, uses, row)];
    PoseKinds added;
    for (int column = 0; column < array.columns; ++column) {
      const ColumnUse& use = uses[column];
      if (!use.kind || use.axis < 0) continue;
      KindPoints& points = added[*use.kind];
      if (points.empty()) points.emplace_back(0, 0, 0);
      points.front()[use.axis] = array.at(row, column);
    }
    for (const auto& [kind, points] : added) pose[kind].push_back(points.front());
  }
}

/// A pixel that some programs write where they found none.
bool is_missing(const Eigen::Vector2d& pixel) {
  return !pixel.allFinite() || pixel == Eigen::Vector2d(-1, -1) || pixel.isZero(0);
}

std::vector<Eigen::Vector2d> pixels_of(const KindPoints& points) {
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector3d& point : points) {
    pixels.emplace_back(point.head<2>());
    if (is_missing(pixels.back())) pixels.back() = {nan, nan};
  }
  return pixels;
}

/// Splits lists of all poses one after the other, where the board is given once.
void split_by_board(FoundPoses& found) {
  if (found.poses.size() != 1) return;
  PoseKinds whole = found.poses.begin()->second;
  const std::size_t count = whole[PointKind::board].size();
  const std::size_t all = whole[PointKind::camera].size();
  if (count == 0 || all <= count || all % count != 0) return;

  found = {};
  for (std::size_t at = 0; at < all; ++at) {
    PoseKinds& pose = found[std::to_string(at / count + 1)];
    for (const auto& [kind, points] : whole) {
      const std::size_t place = kind == PointKind::board ? at % count : at;
      if (place < points.size()) pose[kind].push_back(points[place]);
    }
  }
}

/// Poses that lack a kind take the one of arrays that name no pose: a board that all share.
void share_boards(FoundPoses& found) {
  const auto shared = found.poses.find("");
  if (shared == found.poses.end() || found.poses.size() == 1) return;

  const PoseKinds all = shared->second;
  found.poses.erase(shared);
  std::erase(found.order, "");
  for (auto& [name, pose] : found.poses) pose.insert(all.begin(), all.end());
}

PosePoints pose_points(const std::string& name, PoseKinds pose) {
  const std::size_t count = pose[PointKind::board].size();
  for (const PointKind kind : {PointKind::camera, PointKind::projector}) {
    throw_if(
        count == 0 || pose[kind].size() != count,
        "pose {} has {} points of the board and {} of the {}; expected as many, with nan where "
        "one is missing",
        name.empty() ? "1" : name, count, pose[kind].size(),
        kind_names.at(static_cast<std::size_t>(kind)));
  }

  const bool is_number = number_in<double>(name).has_value() || name.empty();
  return {(is_number ? "pose" : "") + name, pose[PointKind::board],
          pixels_of(pose[PointKind::camera]), pixels_of(pose[PointKind::projector])};
}

/// How the columns of the first array were read.
std::string described_layout(const std::vector<PointArray>& arrays, const FoundPoses& found) {
  Words columns;
  const auto first =
      std::ranges::find_if(arrays, [](const PointArray& array) { return !uses_of(array).empty(); });
  for (const ColumnUse& use : uses_of(*first)) {
    if (use.is_pose) columns.emplace_back("pose");
    if (!use.kind || use.axis < 0) continue;
    const char* const axes = *use.kind == PointKind::board ? "xyz" : "uv-";
    columns.push_back(
        fmt::format("{} {}", kind_names.at(static_cast<std::size_t>(*use.kind)), axes[use.axis]));
  }
  return fmt::format("{} poses; columns of {}: {}", found.order.size(), first->name,
                     fmt::join(columns, ", "));
}

}  // namespace

PointLists read_point_lists(const fs::path& path) {
  const std::vector<PointArray> arrays = read_point_arrays(path);
  return naming(path.string(), [&] {
    FoundPoses found;
    Words names;
    for (const PointArray& array : arrays) {
      names.push_back(fmt::format("{} ({} columns)", array.name, array.columns));
      if (!uses_of(array).empty()) add_array(array, found);
    }

    throw_if(found.poses.empty(),
             "no points among {}; a table has the columns pose, board x, y, camera u, v, projector "
             "u, v, and arrays or files are named board, camera and projector",
             fmt::join(names, ", "));
    split_by_board(found);
    share_boards(found);

    PointLists lists{.layout = described_layout(arrays, found)};
    for (const std::string& name : found.order) {
      lists.poses.push_back(pose_points(name, found.poses.at(name)));
    }
    std::ranges::sort(lists.poses, before_in_order, &PosePoints::name);
    return lists;
  });
}

void write_point_list(const fs::path& path, const std::vector<PosePoints>& poses) {
  std::string text = "pose,board_x,board_y,board_z,camera_u,camera_v,projector_u,projector_v\n";

  for (const PosePoints& pose : poses) {
    for (std::size_t i = 0; i < pose.board.size(); ++i) {
      const Eigen::Vector3d& board = pose.board[i];
      const Eigen::Vector2d &camera = pose.camera[i], &projector = pose.projector[i];
      text += fmt::format("{},{},{},{},{},{},{},{}\n", pose.name, board.x(), board.y(), board.z(),
                          camera.x(), camera.y(), projector.x(), projector.y());
    }
  }
  write_file(path, text);
}

}  // namespace slipstream
