#include "bench/opencv_peers.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#ifdef SLIPSTREAM_OPENCV_STRUCTURED_LIGHT
#include <opencv2/structured_light/sinusoidalpattern.hpp>
#endif

#include "geometry/triangulator.h"

namespace slipstream {
namespace {

/// OpenCV has no read-only images; these functions do not write to them.
std::vector<cv::Mat> mats_of(const Frames<std::uint8_t>& frames) {
  std::vector<cv::Mat> mats;
  for (const auto& frame : frames) {
    mats.emplace_back(frame.height(), frame.width(), CV_8U, const_cast<std::uint8_t*>(frame.row(0)),
                      static_cast<std::size_t>(frame.stride()));
  }
  return mats;
}

cv::Mat projection(const Eigen::RowVector4d& first, const Eigen::RowVector4d& second,
                   const Eigen::RowVector4d& third) {
  cv::Mat matrix(3, 4, CV_64F);
  for (int column = 0; column < 4; ++column) {
    matrix.at<double>(0, column) = first(column);
    matrix.at<double>(1, column) = second(column);
    matrix.at<double>(2, column) = third(column);
  }
  return matrix;
}

/// Frames to points; keeps buffers between calls, as a loop over scans would.
class ByHand {
 public:
  ByHand(const Frames<std::uint8_t>& frames, const Scanner& scanner, Axis axis)
      : frames_(mats_of(frames)) {
    const ProjectionMatrices m = projection_matrices(scanner, axis);
    camera_ = projection(m.camera.row(0), m.camera.row(1), m.camera.row(2));
    projector_ =
        projection(m.projector_coordinate, Eigen::RowVector4d(0, 0, 0, 0.5), m.projector_depth);
  }

  void operator()() {
    const auto N = static_cast<double>(frames_.size());
    cv::Mat sine = cv::Mat::zeros(frames_[0].size(), CV_32F);
    cv::Mat cosine = sine.clone();
    for (std::size_t n = 0; n < frames_.size(); ++n) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(n) / N;
      cv::Mat frame;
      frames_[n].convertTo(frame, CV_32F);
      cv::scaleAdd(frame, std::sin(angle), sine, sine);
      cv::scaleAdd(frame, std::cos(angle), cosine, cosine);
    }
    cv::Mat phase, modulation;
    cv::phase(cosine, sine, phase);
    cv::magnitude(cosine, sine, modulation);
    std::vector<cv::Point2f> seen, lit;
    for (int row = 0; row < phase.rows; ++row) {
      for (int column = 0; column < phase.cols; ++column) {
        if (modulation.at<float>(row, column) * 2 / N < 15) continue;
        seen.emplace_back(static_cast<float>(column), static_cast<float>(row));
        lit.emplace_back(phase.at<float>(row, column) / (2 * std::numbers::pi_v<float>), 0.5F);
      }
    }
    if (!seen.empty()) cv::triangulatePoints(camera_, projector_, seen, lit, points_);
  }

 private:
  std::vector<cv::Mat> frames_;
  cv::Mat camera_, projector_, points_;
};

}  // namespace

std::function<void()> opencv_psp([[maybe_unused]] const Frames<std::uint8_t>& frames) {
#ifdef SLIPSTREAM_OPENCV_STRUCTURED_LIGHT
  using Pattern = cv::structured_light::SinusoidalPattern;
  auto settings = cv::makePtr<Pattern::Params>();
  settings->width = frames[0].width();
  settings->height = frames[0].height();
  settings->methodId = cv::structured_light::PSP;
  const cv::Ptr<Pattern> pattern = Pattern::create(settings);
  return [pattern, mats = mats_of(frames), phase = cv::Mat(), shadow = cv::Mat()]() mutable {
    cv::setNumThreads(1);
    pattern->computePhaseMap(mats, phase, shadow);
  };
#else
  return {};
#endif
}

std::function<void()> opencv_by_hand(const Frames<std::uint8_t>& frames, const Scanner& scanner,
                                     Axis axis) {
  const auto work = std::make_shared<ByHand>(frames, scanner, axis);
  return [work] {
    cv::setNumThreads(1);
    (*work)();
  };
}

}  // namespace slipstream
