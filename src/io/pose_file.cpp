#include "io/pose_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "base/numbers.h"
#include "base/printable.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/unique_keys.h"

namespace slipstream {
namespace {

constexpr std::array<std::string_view, 4> rotation_entries{"matrix", "quaternion",
                                                           "rotation_vector", "euler"};
constexpr std::array<std::string_view, 10> pose_entries{
    "from",  "to",    "unit",   "matrix",     "quaternion", "rotation_vector",
    "euler", "order", "angles", "translation"};

[[noreturn]] void refuse_entry(const YAML::Mark& mark, std::string_view why) {
  throw Error(fmt::format("line {}: {}", std::max(mark.line, 0) + 1, why));
}

/// Calls `read`; its Error gets the line and the name of the entry.
template <class Read>
auto in_entry(const YAML::Node& node, std::string_view name, const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    refuse_entry(node.Mark(), fmt::format("{}: {}", name, error.what()));
  }
}

/// The file's entries, by name.
class PoseEntries {
 public:
  explicit PoseEntries(const YAML::Node& root) : root_(root) {
    if (!root.IsMap()) {
      refuse_entry(root.Mark(), "expected the entries of a pose, e.g. from: camera");
    }

    for (const auto& entry : root) {
      const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : "";
      if (std::ranges::find(pose_entries, name) != pose_entries.end()) continue;
      refuse_entry(
          entry.first.Mark(),
          fmt::format("a pose has no entry '{}'{}; it has {}", printable(name.substr(0, 40)),
                      did_you_mean(name, pose_entries), fmt::join(pose_entries, ", ")));
    }
  }

  [[nodiscard]] bool has(std::string_view name) const {
    return root_[std::string(name)].IsDefined();
  }

  [[nodiscard]] YAML::Node at(std::string_view name) const {
    throw_if(!has(name), "{} is missing", name);
    return root_[std::string(name)];
  }

  /// A line of text.
  [[nodiscard]] std::string text(std::string_view name) const {
    const YAML::Node node = at(name);
    if (!node.IsScalar() || node.Scalar().empty()) {
      refuse_entry(node.Mark(), fmt::format("{}: expected one word or line of text", name));
    }
    return node.Scalar();
  }

  /// One of two words: whether it is the second.
  [[nodiscard]] bool is_second(std::string_view name, std::string_view first,
                               std::string_view second) const {
    const std::string word = text(name);
    if (word != first && word != second) {
      refuse_entry(at(name).Mark(), fmt::format("{}: '{}' is neither {} nor {}", name,
                                                printable(word.substr(0, 40)), first, second));
    }
    return word == second;
  }

  /// A list of numbers; lists in it, the rows of a matrix, are joined.
  [[nodiscard]] std::vector<double> numbers(std::string_view name) const {
    std::vector<double> numbers;
    for_each_number(at(name), name, [&](double number) { numbers.push_back(number); });
    return numbers;
  }

  /// The list of this many numbers.
  template <int count>
  [[nodiscard]] Eigen::Matrix<double, count, 1> vector(std::string_view name) const {
    const std::vector<double> list = numbers(name);
    if (list.size() != count) {
      refuse_entry(at(name).Mark(),
                   fmt::format("{}: expected {} numbers, got {}", name, count, list.size()));
    }
    return Eigen::Matrix<double, count, 1>(list.data());
  }

 private:
  template <class Visit>
  static void for_each_number(const YAML::Node& node, std::string_view name, const Visit& visit,
                              int depth = 0) {
    if (node.IsSequence() && depth < 2) {
      for (const YAML::Node& inner : node) for_each_number(inner, name, visit, depth + 1);
      return;
    }

    const bool is_listed = node.IsScalar() && depth > 0;
    if (!is_listed) {
      refuse_entry(node.Mark(),
                   fmt::format("{}: expected a list of numbers, e.g. [0, 0, 500]", name));
    }

    const std::string text = printable(node.Scalar().substr(0, 40));
    const auto number = number_in<double>(node.Scalar());
    if (!number) refuse_entry(node.Mark(), fmt::format("{}: '{}' is not a number", name, text));
    if (!std::isfinite(*number)) {
      refuse_entry(node.Mark(), fmt::format("{}: {} is not finite", name, text));
    }
    visit(*number);
  }

  YAML::Node root_;
};

/// The only rotation that is given.
std::string_view rotation_given(const PoseEntries& given) {
  std::vector<std::string_view> found;
  std::ranges::copy_if(rotation_entries, std::back_inserter(found),
                       [&](std::string_view name) { return given.has(name); });

  throw_if(found.empty(), "no rotation; give one of {}", fmt::join(rotation_entries, ", "));
  throw_if(found.size() > 1, "{} are given, but a pose has one rotation; keep one",
           fmt::join(found, " and "));
  return found.front();
}

/// Throws Error if an entry is there that belongs to another rotation.
void require_unused(const PoseEntries& given, std::string_view name, std::string_view rotation) {
  if (!given.has(name)) return;
  refuse_entry(given.at(name).Mark(), fmt::format("{}: {} has none; remove it", name, rotation));
}

/// Radians in one unit of the file's angles. A rotation vector is in radians unless it says else.
double angle_unit(const PoseEntries& given, bool is_optional) {
  if (is_optional && !given.has("angles")) return 1;
  throw_if(!given.has("angles"), "angles is missing; add angles: degrees, or angles: radians");
  return given.is_second("angles", "degrees", "radians") ? 1 : degree;
}

/// The matrix: 3x3, or with a column for the translation 3x4 or 4x4.
Eigen::Isometry3d matrix_pose(const PoseEntries& given) {
  const std::vector<double> numbers = given.numbers("matrix");
  const YAML::Node node = given.at("matrix");
  const bool is_rotation = numbers.size() == 9;
  if (!is_rotation && numbers.size() != 12 && numbers.size() != 16) {
    refuse_entry(node.Mark(),
                 fmt::format("matrix: expected 3 rows of 3, or 3 or 4 rows of 4 numbers, got {}",
                             numbers.size()));
  }
  if (!is_rotation) require_unused(given, "translation", "a matrix with a fourth column");

  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  const std::size_t columns = is_rotation ? 3 : 4;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    matrix(static_cast<int>(i / columns), static_cast<int>(i % columns)) = numbers[i];
  }
  return in_entry(node, "matrix", [&] { return pose_of_matrix(matrix); });
}

Eigen::Isometry3d pose_given(const PoseEntries& given) {
  const std::string_view rotation = rotation_given(given);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();

  // 1. The rotation, and the entries that say how to read it.
  if (rotation == "euler") {
    const std::string order_text = given.text("order");
    const EulerOrder order =
        in_entry(given.at("order"), "order", [&] { return euler_order_named(order_text); });
    const Eigen::Vector3d angles = angle_unit(given, false) * given.vector<3>("euler");
    pose.linear() = rotation_of_euler(angles, order);
  } else if (rotation == "quaternion") {
    const std::string order_text = given.text("order");
    const QuaternionOrder order =
        in_entry(given.at("order"), "order", [&] { return quaternion_order_named(order_text); });
    const Eigen::Vector4d numbers = given.vector<4>("quaternion");
    pose.linear() = in_entry(given.at("quaternion"), "quaternion",
                             [&] { return rotation_of_quaternion(numbers, order); });
    require_unused(given, "angles", "a quaternion");
  } else if (rotation == "rotation_vector") {
    const double unit = angle_unit(given, true);
    pose.linear() = rotation_of_vector(unit * given.vector<3>("rotation_vector"));
    require_unused(given, "order", "a rotation vector");
  } else {
    pose = matrix_pose(given);
    require_unused(given, "order", "a matrix");
    require_unused(given, "angles", "a matrix");
  }

  // 2. The translation, unless it is the matrix's last column.
  const bool is_in_matrix = rotation == "matrix" && given.numbers("matrix").size() != 9;
  if (!is_in_matrix) pose.translation() = given.vector<3>("translation");
  if (given.is_second("unit", "mm", "m")) pose.translation() *= 1000;
  return pose;
}

FramePose pose_from_entries(const PoseEntries& given) {
  FramePose pose;
  pose.from = given.text("from");
  pose.to = given.text("to");
  in_entry(given.at("from"), "from", [&] { require_frame_name(pose.from); });
  in_entry(given.at("to"), "to", [&] { require_frame_name(pose.to); });
  if (pose.from == pose.to) {
    refuse_entry(given.at("to").Mark(),
                 fmt::format("from and to are both {}; a pose is between two frames", pose.to));
  }

  pose.transform = pose_given(given);
  return pose;
}

/// "[1, 2, 3]", without negative zeros.
template <class Numbers>
std::string list_of(const Numbers& numbers) {
  std::vector<double> list(numbers.begin(), numbers.end());
  for (double& number : list) number += 0.0;
  return fmt::format("[{}]", fmt::join(list, ", "));
}

}  // namespace

FramePose read_pose(const std::filesystem::path& file) {
  return pose_in_text(read_text(file), file.string());
}

FramePose pose_in_text(const std::string& text, const std::string& name) {
  return naming(name, [&] { return pose_from_entries(PoseEntries(yaml_document(text))); });
}

std::string text_of(const FramePose& pose, const PoseNotation& notation) {
  const double unit = notation.metres ? 1000 : 1, angle = notation.degrees ? degree : 1;
  const char* const angles = notation.degrees ? "degrees" : "radians";
  const Eigen::Matrix3d turn = pose.transform.linear();
  const Eigen::Vector3d place = pose.transform.translation() / unit;

  std::string text = fmt::format(
      "# Maps a point of the frame {0} to the frame {1}.\n"
      "from: {0}\nto: {1}\nunit: {2}\n",
      pose.from, pose.to, notation.metres ? "m" : "mm");

  using Rotation = PoseNotation::Rotation;
  if (notation.rotation == Rotation::matrix) {
    Eigen::Matrix4d matrix = pose.transform.matrix();
    matrix.topRightCorner<3, 1>() = place;
    text += "matrix:\n";
    for (const auto& row : matrix.rowwise()) text += fmt::format("  - {}\n", list_of(row));
    return text;
  }

  text += fmt::format("translation: {}\n", list_of(place));
  if (notation.rotation == Rotation::quaternion) {
    text += fmt::format("quaternion: {}\norder: {}\n",
                        list_of(quaternion_of(turn, notation.quaternion_order)),
                        name_of(notation.quaternion_order));
  } else if (notation.rotation == Rotation::rotation_vector) {
    text += fmt::format("rotation_vector: {}\nangles: {}\n",
                        list_of(Eigen::Vector3d(vector_of(turn) / angle)), angles);
  } else {
    text += fmt::format("euler: {}\norder: {}\nangles: {}\n",
                        list_of(Eigen::Vector3d(euler_of(turn, notation.euler_order) / angle)),
                        name_of(notation.euler_order), angles);
  }
  return text;
}

void write_pose(const std::filesystem::path& file, const FramePose& pose,
                const PoseNotation& notation) {
  require_ending(file, "pose file", {".yaml", ".yml"});
  write_file(file, text_of(pose, notation));
}

PoseNotation pose_notation_named(std::string_view text) {
  using Rotation = PoseNotation::Rotation;
  std::string_view order = text;
  const std::string_view kind = take_until(order, ' ');

  if (text == "matrix") return {};
  if (text == "rotation-vector") return {.rotation = Rotation::rotation_vector};
  if (kind == "quaternion") {
    const QuaternionOrder named = quaternion_order_named(order);
    return {.rotation = Rotation::quaternion, .quaternion_order = named};
  }
  if (kind == "euler") {
    const EulerOrder named = euler_order_named(order);
    return {.rotation = Rotation::euler, .euler_order = named};
  }

  throw Error(fmt::format(
      "'{}' is not a notation of poses; use matrix, 'quaternion xyzw', 'quaternion wxyz', "
      "rotation-vector, or euler with its order, e.g. 'euler intrinsic zyx'",
      printable(text.substr(0, 40))));
}

}  // namespace slipstream
