#include "slipstream/calibrate/warnings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace slipstream {
namespace {

constexpr double degree = std::numbers::pi / 180;

class Warnings {
 public:
  template <class... Values>
  void add_if(bool holds, fmt::format_string<Values...> format, Values&&... values) {
    if (holds) lines_.push_back(fmt::format(format, std::forward<Values>(values)...));
  }
  [[nodiscard]] std::vector<std::string> lines() const { return lines_; }

 private:
  std::vector<std::string> lines_;
};

void about_lens(Warnings& warnings, const char* device, const Lens& lens,
                const LensDeviation& deviation, double covered) {
  const double focal = lens.intrinsic(0, 0);
  const double doubt = deviation.focal.maxCoeff() / focal;
  warnings.add_if(doubt > 0.002,
                  "the {}'s focal length is uncertain by {:.2g} %: more poses, tilted more", device,
                  100 * doubt);
  warnings.add_if(covered < 0.5,
                  "the boards covered {:.0f} % of the {}'s picture: its distortion is not known in "
                  "the rest",
                  100 * covered, device);
}

}  // namespace

std::vector<std::string> warnings_about(const GeometryCalibration& calibration) {
  constexpr std::size_t few_poses = 5;
  const auto& [state, deviation, camera_lens, projector_lens, rms, poses, views, covered_camera,
               covered_projector, largest_tilt, none_yet] = calibration;
  Warnings warnings;
  warnings.add_if(poses.size() < few_poses, "only {} poses: ten or more are better", poses.size());
  warnings.add_if(largest_tilt < 15 * degree,
                  "all boards are nearly parallel (at most {:.0f} degrees apart): focal lengths "
                  "and distances are uncertain; tilt the board by 20 to 40 degrees, each way",
                  largest_tilt / degree);
  about_lens(warnings, "camera", state.scanner.camera, deviation.camera, covered_camera);
  about_lens(warnings, "projector", state.scanner.projector, deviation.projector,
             covered_projector);
  warnings.add_if(rms.camera > 0.5, "camera RMS {:.2g} px is large: is the board flat and sharp?",
                  rms.camera);
  warnings.add_if(rms.projector > 0.7,
                  "projector RMS {:.2g} px is large: is the projector's light on the board bright "
                  "enough, and the response linear?",
                  rms.projector);
  for (const CalibratedPose& pose : poses) {
    warnings.add_if(pose.lit < 0.9 * pose.corners,
                    "{}: the projector coordinate of {} of {} corners could not be told", pose.name,
                    pose.corners - pose.lit, pose.corners);
    warnings.add_if(pose.rms.stereo > 2.5 * rms.stereo,
                    "{}: RMS {:.2g} px is far above the whole's {:.2g} px; did the board move?",
                    pose.name, pose.rms.stereo, rms.stereo);
    warnings.add_if(pose.left_out && std::abs(pose.left_out->scale_error) > 0.005,
                    "{}: left out, it comes out {:+.2g} % too large", pose.name,
                    pose.left_out ? 100 * pose.left_out->scale_error : 0.0);
  }
  return warnings.lines();
}

}  // namespace slipstream
