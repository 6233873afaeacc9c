#include "slipstream/cloud.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "base/parallel_rows.h"
#include "base/printable.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

constexpr std::array<std::string_view, validity_count> validity_names{
    "valid",           "too dark",
    "saturated",       "doubtful fringe order",
    "no point",        "outside the projector's field",
    "out of range",    "low trust",
    "mixed pixel",     "outlier",
    "small component", "outside the region",
    "moved",           "lit by other surfaces"};

/// Moves the standard deviations of a point: noise moves it along its ray, which has this direction
/// in the new frame.
void turn_sigma(Uncertainty& uncertainty, int column, int row, const Eigen::Vector3d& direction) {
  float &x = uncertainty.x(column, row), &y = uncertainty.y(column, row),
        &z = uncertainty.z(column, row);
  const double along = Eigen::Vector3d(x, y, z).norm();
  const Eigen::Vector3f turned = (along * direction.normalized()).cwiseAbs().cast<float>();

  // Other errors along the ray turn as it does.
  if (!uncertainty.z_systematic.empty()) uncertainty.z_systematic(column, row) *= turned.z() / z;

  x = turned.x();
  y = turned.y();
  z = turned.z();
}

/// Maps the points, and the standard deviations to the axes of their new frame. `camera`: its
/// centre in the new frame.
void move_points(Cloud& cloud, const Eigen::Isometry3d& motion, const Eigen::Vector3d& camera,
                 Uncertainty* uncertainty) {
  for_each_pixel(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    const Eigen::Vector3d place = motion * position_at(cloud, column, row);

    cloud.x(column, row) = static_cast<float>(place.x());
    cloud.y(column, row) = static_cast<float>(place.y());
    cloud.z(column, row) = static_cast<float>(place.z());
    if (uncertainty != nullptr) turn_sigma(*uncertainty, column, row, place - camera);
  });
}

}  // namespace

void require_frame_name(std::string_view name) {
  const bool valid = !name.empty() && name.size() <= 48 && std::ranges::all_of(name, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("_./-").find(c) != std::string_view::npos;
  });
  throw_if(!valid,
           "'{}' cannot name a frame; use 1 to 48 letters, digits and _ . / -, e.g. robot_base",
           printable(name.substr(0, 64)));
}

FramePose inverse(const FramePose& pose) {
  return {pose.to, pose.from, pose.transform.inverse()};
}

FramePose compose(const FramePose& first, const FramePose& second) {
  throw_if(first.to != second.from,
           "the first pose ends in the frame {}, but the second begins in {}; both must be one",
           first.to, second.from);
  return {first.from, second.to, second.transform * first.transform};
}

FramePose pose_from_frame(const FramePose& pose, std::string_view from) {
  if (pose.from == from) return pose;
  throw_if(pose.to != from,
           "the pose is between the frames {} and {}, expected one from or to the frame {}",
           pose.from, pose.to, from);
  return inverse(pose);
}

std::shared_ptr<const FramePose> frame_after(const std::shared_ptr<const FramePose>& frame,
                                             const FramePose& pose) {
  FramePose whole = pose_from_frame(pose, frame ? std::string_view(frame->to) : camera_frame);
  if (whole.to == camera_frame) return nullptr;

  if (frame) whole = compose(*frame, whole);
  return std::make_shared<const FramePose>(std::move(whole));
}

void move_to_frame(Cloud& cloud, const FramePose& pose, Uncertainty* uncertainty) {
  const std::shared_ptr<const FramePose> after = frame_after(cloud.frame, pose);
  const Eigen::Isometry3d motion = pose_from_frame(pose, frame_name(cloud)).transform;
  const Eigen::Vector3d camera =
      after ? after->transform.translation() : Eigen::Vector3d(Eigen::Vector3d::Zero());

  move_points(cloud, motion, camera, uncertainty);
  cloud.frame = after;
}

void require_camera_frame(const Cloud& cloud) {
  throw_if(cloud.frame != nullptr,
           "the cloud is in the frame {}, but this is computed in the camera's, along its rays; "
           "move the cloud afterwards",
           frame_name(cloud));
}

void move_to_camera(Cloud& cloud, Uncertainty* uncertainty) {
  if (cloud.frame) move_to_frame(cloud, FramePose(*cloud.frame), uncertainty);
}

std::string_view name_of(Validity validity) {
  return validity_names[static_cast<std::size_t>(validity)];
}

ValidityCounts count_by_validity(const Image<Validity>& validity) {
  // Several counters: neighbours usually count the same, and each increment waits for the last.
  constexpr std::size_t at_once = 8;
  std::array<std::array<std::uint32_t, 16>, at_once> of_each{};

  const std::size_t whole = validity.pixel_count() / at_once * at_once;
  for (const Validity* pixel = validity.begin(); pixel != validity.begin() + whole;
       pixel += at_once) {
    for (std::size_t i = 0; i < at_once; ++i) ++of_each[i][static_cast<std::size_t>(pixel[i])];
  }

  // The last few pixels, and the sum of the counters.
  ValidityCounts counts{};
  std::for_each(validity.begin() + whole, validity.end(),
                [&](Validity rest) { ++counts[static_cast<std::size_t>(rest)]; });
  for (const auto& one : of_each) {
    std::transform(counts.begin(), counts.end(), one.begin(), counts.begin(), std::plus<>());
  }

  return counts;
}

PredictedRms predicted_rms(const Uncertainty& uncertainty) {
  double noise = 0, all = 0, count = 0;
  for (std::size_t i = 0; i < uncertainty.z.pixel_count(); ++i) {
    const double sigma = uncertainty.z.begin()[i], of_noise = uncertainty.z_of_noise.begin()[i];
    if (!std::isfinite(sigma)) continue;
    noise += of_noise * of_noise;
    all += sigma * sigma;
    ++count;
  }

  if (count == 0) return {};
  return {std::sqrt(noise / count), std::sqrt(all / count)};
}

double median_depth(const Uncertainty& uncertainty) {
  std::vector<float> sigma = finite_values(uncertainty.z);
  return sigma.empty() ? 0 : quantile(sigma, 0.5);
}

}  // namespace slipstream
