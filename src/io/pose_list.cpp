#include "io/pose_list.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "base/numbers.h"
#include "base/printable.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/point_elements.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view separators = " \t,;";

Eigen::Matrix3d rotation_of(double w, double x, double y, double z) {
  const Eigen::Quaterniond quaternion(w, x, y, z);
  throw_if(!(quaternion.norm() > 1e-6), "its quaternion is zero");
  return quaternion.normalized().toRotationMatrix();
}

/// Throws Error without a file name.
ListedPose pose_of(const std::vector<std::string_view>& words, double unit) {
  std::vector<double> numbers;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto number = number_in<double>(words[i]);
    throw_if(!number, "'{}' is not a number", words[i].substr(0, 20));
    numbers.push_back(*number);
  }

  ListedPose pose{.name = std::string(words[0])};
  if (numbers.size() == 7) {
    const Eigen::Vector3d shift = unit * Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
    const double a = numbers[3], b = numbers[4], c = numbers[5], d = numbers[6];
    pose.scalar_last.linear() = rotation_of(d, a, b, c);
    pose.scalar_first.linear() = rotation_of(a, b, c, d);
    pose.scalar_last.translation() = pose.scalar_first.translation() = shift;
    return pose;
  }

  throw_if(numbers.size() != 12 && numbers.size() != 16,
           "a pose has a name and 7 numbers (x y z and a quaternion), or 12 or 16 (a matrix), but "
           "here are {}",
           numbers.size());
  Eigen::Isometry3d& matrix = pose.scalar_last;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      const double number = numbers[static_cast<std::size_t>(4 * row + column)];
      matrix(row, column) = column < 3 ? number : unit * number;
    }
  }

  constexpr double rounding = 1e-3;
  const Eigen::Matrix3d turn = matrix.linear();
  throw_if(!(turn * turn.transpose()).isIdentity(rounding) || turn.determinant() < 0,
           "its matrix is not a rotation");
  matrix.linear() = Eigen::Quaterniond(turn).normalized().toRotationMatrix();
  pose.scalar_first = matrix;
  pose.is_matrix = true;
  return pose;
}

}  // namespace

std::vector<ListedPose> read_pose_list(const fs::path& path, double unit) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());

  std::vector<ListedPose> poses;
  for (int line_number = 1; !text.empty(); ++line_number) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);

    const auto words = words_of(line, separators.data());
    if (words.empty() || words[0].starts_with('#')) continue;
    poses.push_back(naming(fmt::format("{}: line {}", path.string(), line_number),
                           [&] { return pose_of(words, unit); }));
  }
  throw_if(poses.empty(), "{}: has no poses", path.string());
  return poses;
}

void write_pose_list(const fs::path& path,
                     const std::vector<std::pair<std::string, Eigen::Isometry3d>>& poses) {
  std::string text = "# name x y z (mm) qx qy qz qw, from the view's frame to the model's\n";
  for (const auto& [name, pose] : poses) {
    const Eigen::Quaterniond turn(pose.linear());
    const Eigen::Vector3d shift = pose.translation();
    fmt::format_to(std::back_inserter(text),
                   "{} {:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}\n", printable(name),
                   shift.x(), shift.y(), shift.z(), turn.x(), turn.y(), turn.z(), turn.w());
  }
  write_file(path, text);
}

}  // namespace slipstream
