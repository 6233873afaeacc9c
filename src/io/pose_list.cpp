#include "io/pose_list.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "base/numbers.h"
#include "base/printable.h"
#include "base/throw_if-inl.h"
#include "geometry/rotation.h"
#include "io/file.h"
#include "io/point_elements.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view separators = " \t,;";

/// A line's name and the text behind it.
struct NamedLine {
  std::string name{};
  std::string_view rest{};
};

/// Takes a name in double quotes, or the first word.
NamedLine named_line(std::string_view line) {
  NamedLine named;
  if (!line.starts_with('"')) {
    named.name = line.substr(0, line.find_first_of(separators));
    named.rest = line.substr(named.name.size());
    return named;
  }

  // Two quotes within the name are one.
  std::size_t at = 1;
  while (at < line.size()) {
    const bool is_quote = line[at] == '"';
    if (is_quote && (at + 1 == line.size() || line[at + 1] != '"')) break;
    named.name += line[at];
    at += is_quote ? 2 : 1;
  }
  throw_if(at >= line.size(), "the name has no closing quote");
  named.rest = line.substr(at + 1);
  return named;
}

/// The name as named_line reads it.
std::string quoted(const std::string& name) {
  const bool is_plain = !name.empty() && !name.starts_with('#') && !name.starts_with('"') &&
                        name.find_first_of(separators) == name.npos;
  if (is_plain) return name;

  std::string text = "\"";
  for (const char letter : name) {
    if (letter == '"') text += '"';
    text += letter;
  }
  return text + '"';
}

/// The name of a unit, from its length in mm.
std::string unit_name(double unit) {
  if (unit == 1) return "mm";
  if (unit == 10) return "cm";
  return unit == 1000 ? "m" : fmt::format("{:g} mm", unit);
}

/// The pose of a matrix of 12 or 16 numbers, row by row.
Eigen::Isometry3d pose_of_rows(const std::vector<double>& numbers) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) = numbers[i];
  }
  return pose_of_matrix(matrix);
}

/// Throws Error without a file name.
ListedPose pose_of(std::string_view line, double unit) {
  const NamedLine named = named_line(line);
  std::vector<double> numbers;
  for (const std::string_view word : words_of(named.rest, separators.data())) {
    const auto number = number_in<double>(word);
    throw_if(!number, "'{}' is not a number", word.substr(0, 20));
    numbers.push_back(*number);
  }
  throw_if(numbers.size() != 7 && numbers.size() != 12 && numbers.size() != 16,
           "a pose has a name and 7 numbers (x y z and a quaternion), or 12 or 16 (a matrix), but "
           "here are {}",
           numbers.size());

  ListedPose pose{.name = named.name};
  if (numbers.size() == 7) {
    const Eigen::Vector3d shift(numbers[0], numbers[1], numbers[2]);
    const Eigen::Vector4d turn(numbers[3], numbers[4], numbers[5], numbers[6]);
    pose.scalar_last = pose_from(rotation_of_quaternion(turn, QuaternionOrder::xyzw), shift);
    pose.scalar_first = pose_from(rotation_of_quaternion(turn, QuaternionOrder::wxyz), shift);
  } else {
    pose.scalar_last = pose.scalar_first = pose_of_rows(numbers);
    pose.is_matrix = true;
  }

  pose.scalar_last.translation() *= unit;
  pose.scalar_first.translation() *= unit;
  throw_if(!pose.scalar_last.translation().allFinite(), "its translation is not finite");
  return pose;
}

}  // namespace

std::vector<ListedPose> read_pose_list(const fs::path& path, double unit) {
  const std::string whole = read_text(path);
  std::string_view text = whole;

  std::vector<ListedPose> poses;
  for (int line_number = 1; !text.empty(); ++line_number) {
    std::string_view line = take_until(text, '\n');
    line.remove_prefix(std::min(line.find_first_not_of(separators), line.size()));
    if (line.empty() || line.starts_with('#')) continue;
    poses.push_back(naming(fmt::format("{}: line {}", path.string(), line_number),
                           [&] { return pose_of(line, unit); }));
  }
  throw_if(poses.empty(), "{}: has no poses", path.string());
  return poses;
}

void write_pose_list(const fs::path& path,
                     const std::vector<std::pair<std::string, Eigen::Isometry3d>>& poses,
                     double unit) {
  std::string text = fmt::format(
      "# name x y z ({}) qx qy qz qw, from the view's frame to the model's\n", unit_name(unit));
  for (const auto& [name, pose] : poses) {
    const Eigen::Quaterniond turn(pose.linear());
    const Eigen::Vector3d shift = pose.translation() / unit;
    fmt::format_to(std::back_inserter(text),
                   "{} {:.9g} {:.9g} {:.9g} {:.9f} {:.9f} {:.9f} {:.9f}\n", quoted(printable(name)),
                   shift.x(), shift.y(), shift.z(), turn.x(), turn.y(), turn.z(), turn.w());
  }
  write_file(path, text);
}

}  // namespace slipstream
