#include "geometry/pose_convention.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>
#include <map>

#include <fmt/ranges.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

using Kind = RotationNotation::Kind;

constexpr std::size_t angle_numbers = 6, quaternion_numbers = 7, matrix_numbers = 16;

RotationNotation euler(const EulerOrder& order, bool degrees) {
  return {.kind = Kind::euler, .order = order, .degrees = degrees};
}

RotationNotation quaternion(QuaternionOrder order, bool conjugate) {
  return {.kind = Kind::quaternion, .quaternion = order, .conjugate = conjugate};
}

RotationNotation matrix(bool by_columns) {
  return {.kind = Kind::matrix, .by_columns = by_columns};
}

/// As the makers' controllers and logs print poses.
const std::map<std::string, RotationNotation, std::less<>>& robots() {
  static const EulerOrder intrinsic_zyx{{2, 1, 0}, true}, extrinsic_xyz{{0, 1, 2}, false},
      intrinsic_zyz{{2, 1, 2}, true};
  static const std::map<std::string, RotationNotation, std::less<>> notations{
      {"abb", quaternion(QuaternionOrder::wxyz, false)},
      {"doosan", euler(intrinsic_zyz, true)},
      {"fanuc", euler(extrinsic_xyz, true)},
      {"franka", matrix(true)},
      {"kawasaki", euler(intrinsic_zyz, true)},
      {"kuka", euler(intrinsic_zyx, true)},
      {"ur", {.kind = Kind::vector}},
      {"yaskawa", euler(extrinsic_xyz, true)}};
  return notations;
}

std::string lower_case(std::string_view text) {
  std::string lower;
  for (const char letter : text) {
    lower += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  return lower;
}

/// The text without blanks at its ends.
std::string_view trimmed(std::string_view text) {
  const std::size_t first = std::min(text.find_first_not_of(' '), text.size());
  text.remove_prefix(first);
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

constexpr std::string_view name_of_unit(double unit) {
  return unit == 1 ? "mm" : "m";
}

/// The three parts of a convention's name.
std::array<std::string, 3> parts_of(const PoseConvention& convention, const PoseFrames& frames) {
  const std::string_view from = convention.inverse ? frames.to : frames.from;
  const std::string_view to = convention.inverse ? frames.from : frames.to;
  return {name_of(convention.rotation), std::string(name_of_unit(convention.unit)),
          fmt::format("{} to {}", from, to)};
}

/// The matrix of 16 numbers.
Eigen::Matrix4d matrix_of(std::span<const double> row, bool by_columns) {
  const Eigen::Matrix4d columns = Eigen::Map<const Eigen::Matrix4d>(row.data());
  return by_columns ? columns : Eigen::Matrix4d(columns.transpose());
}

}  // namespace

std::string name_of(const RotationNotation& notation) {
  const char* const unit = notation.degrees ? "degrees" : "radians";
  switch (notation.kind) {
    case Kind::euler:
      return fmt::format("{} in {}", name_of(notation.order), unit);
    case Kind::vector:
      return fmt::format("rotation vector in {}", unit);
    case Kind::quaternion:
      return fmt::format("{}quaternion {}", notation.conjugate ? "conjugate " : "",
                         name_of(notation.quaternion));
    case Kind::matrix:
      break;
  }
  return notation.by_columns ? "matrix by columns" : "matrix by rows";
}

std::vector<RotationNotation> notations_of(std::size_t numbers) {
  if (numbers == matrix_numbers) return {matrix(false), matrix(true)};

  std::vector<RotationNotation> notations;
  if (numbers == quaternion_numbers) {
    for (const bool conjugate : {false, true}) {
      notations.push_back(quaternion(QuaternionOrder::wxyz, conjugate));
      notations.push_back(quaternion(QuaternionOrder::xyzw, conjugate));
    }
    return notations;
  }

  throw_if(numbers != angle_numbers,
           "a pose has {} numbers; expected 6 (position and three angles), 7 (position and "
           "quaternion) or 16 (matrix)",
           numbers);

  for (const bool degrees : {true, false}) {
    notations.push_back({.kind = Kind::vector, .degrees = degrees});

    for (const bool intrinsic : {true, false}) {
      for (int place = 0; place < 27; ++place) {
        const std::array<int, 3> axes{place / 9, place / 3 % 3, place % 3};
        if (axes[0] == axes[1] || axes[1] == axes[2]) continue;
        notations.push_back(euler({axes, intrinsic}, degrees));
      }
    }
  }
  return notations;
}

Eigen::Isometry3d pose_of(std::span<const double> row, const RotationNotation& notation) {
  if (notation.kind == Kind::matrix) return pose_of_matrix(matrix_of(row, notation.by_columns));

  const Eigen::Vector3d position(row[0], row[1], row[2]);
  throw_if(!position.allFinite(), "the position has a number that is not finite");

  if (notation.kind == Kind::quaternion) {
    const Eigen::Vector4d numbers(row[3], row[4], row[5], row[6]);
    const Eigen::Matrix3d rotation = rotation_of_quaternion(numbers, notation.quaternion);
    return pose_from(notation.conjugate ? Eigen::Matrix3d(rotation.transpose()) : rotation,
                     position);
  }

  const double unit = notation.degrees ? degree : 1;
  const Eigen::Vector3d angles = unit * Eigen::Vector3d(row[3], row[4], row[5]);
  const Eigen::Matrix3d rotation = notation.kind == Kind::vector
                                       ? rotation_of_vector(angles)
                                       : rotation_of_euler(angles, notation.order);
  return pose_from(rotation, position);
}

std::vector<std::optional<Eigen::Isometry3d>> poses_of(const PoseTable& table,
                                                       const RotationNotation& notation) {
  std::vector<std::optional<Eigen::Isometry3d>> poses;
  for (const std::vector<double>& row : table.rows) {
    try {
      const Eigen::Isometry3d pose = pose_of(row, notation);
      poses.emplace_back(pose);
    } catch (const Error&) {
      poses.emplace_back(std::nullopt);
    }
  }
  return poses;
}

std::vector<double> row_of(const Eigen::Isometry3d& pose, const RotationNotation& notation) {
  std::vector<double> row;
  const auto append = [&](const auto& numbers) {
    for (Eigen::Index i = 0; i < numbers.size(); ++i) row.push_back(numbers.data()[i]);
  };

  if (notation.kind == Kind::matrix) {
    const Eigen::Matrix4d columns = pose.matrix(), rows = columns.transpose();
    append(notation.by_columns ? columns : rows);
    return row;
  }

  append(Eigen::Vector3d(pose.translation()));
  const Eigen::Matrix3d rotation = pose.linear();
  const double unit = notation.degrees ? degree : 1;

  switch (notation.kind) {
    case Kind::quaternion: {
      const Eigen::Matrix3d turned = rotation.transpose();
      append(quaternion_of(notation.conjugate ? turned : rotation, notation.quaternion));
      break;
    }
    case Kind::vector:
      append(Eigen::Vector3d(vector_of(rotation) / unit));
      break;
    default:
      append(Eigen::Vector3d(euler_of(rotation, notation.order) / unit));
  }
  return row;
}

std::string name_of(const PoseConvention& convention, const PoseFrames& frames) {
  return fmt::format("{}", fmt::join(parts_of(convention, frames), ", "));
}

std::vector<std::optional<Eigen::Isometry3d>> poses_of(const PoseTable& table,
                                                       const PoseConvention& convention) {
  std::vector<std::optional<Eigen::Isometry3d>> poses = poses_of(table, convention.rotation);
  for (std::optional<Eigen::Isometry3d>& pose : poses) {
    if (!pose) continue;
    pose->translation() *= convention.unit;
    if (convention.inverse) pose = pose->inverse();
  }
  return poses;
}

std::vector<PoseConvention> conventions_of(std::size_t numbers, const PoseFrames& frames,
                                           std::string_view known) {
  // 1. All that the numbers allow.
  std::vector<PoseConvention> conventions;
  for (const RotationNotation& notation : notations_of(numbers)) {
    for (const double unit : {1.0, 1000.0}) {
      conventions.push_back({notation, unit, false});
      conventions.push_back({notation, unit, true});
    }
  }

  // 2. Each known part leaves those that have it.
  while (!trimmed(known).empty()) {
    const std::string text = lower_case(trimmed(take_until(known, ',')));
    const auto robot = notation_of_robot(text);
    const std::string part = robot ? name_of(*robot) : text;

    std::erase_if(conventions, [&](const PoseConvention& convention) {
      const auto parts = parts_of(convention, frames);
      return std::ranges::find(parts, part) == parts.end();
    });
    throw_if(conventions.empty(),
             "'{}' is no convention of poses with {} numbers; expected parts such as '{}', 'mm', "
             "'{} to {}', or one of {}",
             text, numbers, name_of(notations_of(numbers).front()), frames.from, frames.to,
             fmt::join(robot_names(), ", "));
  }
  return conventions;
}

std::vector<std::string> robot_names() {
  std::vector<std::string> names;
  for (const auto& [name, notation] : robots()) names.push_back(name);
  return names;
}

std::optional<RotationNotation> notation_of_robot(std::string_view name) {
  const auto found = robots().find(lower_case(name));
  return found == robots().end() ? std::nullopt : std::optional(found->second);
}

}  // namespace slipstream
