#include "io/frame_title.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <vector>

#include <fmt/ranges.h>

#include "base/numbers.h"
#include "geometry/rotation.h"
#include "slipstream/error.h"

namespace slipstream {
namespace {

constexpr std::string_view title_start = "slipstream, ", title_end = " frame, mm";
constexpr std::string_view viewpoint_word = "viewpoint ";

bool starts_with_viewpoint(std::string_view line) {
  const auto same = [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; };
  return line.size() >= viewpoint_word.size() &&
         std::equal(viewpoint_word.begin(), viewpoint_word.end(), line.begin(),
                    [&](char word, char in_line) { return same(in_line, word); });
}

/// The pose of "tx ty tz qw qx qy qz"; nullopt if it is none.
std::optional<Eigen::Isometry3d> viewpoint_in(std::string_view text) {
  const std::vector<double> numbers = numbers_in<double>(text, ' ');
  if (numbers.size() != 7) return std::nullopt;

  const Eigen::Map<const Eigen::Vector3d> place(numbers.data());
  const Eigen::Map<const Eigen::Vector4d> turn(numbers.data() + 3);
  if (!place.allFinite()) return std::nullopt;

  try {
    return pose_from(rotation_of_quaternion(turn, QuaternionOrder::wxyz), place);
  } catch (const Error&) {  // a damaged header only loses the camera's place
    return std::nullopt;
  }
}

}  // namespace

std::string frame_title(const FramePose* frame) {
  return fmt::format("{}{}{}", title_start,
                     frame == nullptr ? camera_frame : std::string_view(frame->to), title_end);
}

std::string viewpoint_text(const FramePose* frame) {
  if (frame == nullptr) return "0 0 0 1 0 0 0";
  const Eigen::Vector3d place = frame->transform.translation();
  const Eigen::Vector4d turn = quaternion_of(frame->transform.linear(), QuaternionOrder::wxyz);

  return fmt::format("{} {}", fmt::join(place.begin(), place.end(), " "),
                     fmt::join(turn.begin(), turn.end(), " "));
}

std::string frame_comments(const FramePose* frame, std::string_view mark) {
  std::string lines = fmt::format("{} {}\n", mark, frame_title(frame));
  if (frame != nullptr) {
    lines += fmt::format("{} {}{}\n", mark, viewpoint_word, viewpoint_text(frame));
  }
  return lines;
}

std::shared_ptr<const FramePose> frame_of_comments(std::string_view text) {
  FrameTitle title;
  while (text.starts_with("# ")) {
    const std::string_view line = take_until(text, '\n');
    title.read(line.substr(2));
  }
  return title.frame();
}

void FrameTitle::read(std::string_view line) {
  if (starts_with_viewpoint(line)) {
    camera_ = viewpoint_in(line.substr(viewpoint_word.size()));
    return;
  }

  const std::size_t start = line.find(title_start), end = line.find(title_end);
  const bool has_title =
      start != line.npos && end != line.npos && end >= start + title_start.size();
  if (!has_title || !name_.empty()) return;
  name_ = line.substr(start + title_start.size(), end - start - title_start.size());
}

std::shared_ptr<const FramePose> FrameTitle::frame() const {
  if (name_.empty() || name_ == camera_frame) return nullptr;
  try {
    require_frame_name(name_);
  } catch (const Error&) {  // not a name that this program writes
    return nullptr;
  }

  return std::make_shared<const FramePose>(
      FramePose{std::string(camera_frame), name_, camera_.value_or(Eigen::Isometry3d::Identity())});
}

}  // namespace slipstream
