#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "slipstream/scanner.h"
#include "slipstream/surface.h"

namespace slipstream {

/// A small piece of an object's surface, in the object's frame.
struct ModelElement {
  Eigen::Vector3f position;  ///< mm
  Eigen::Vector3f normal;    ///< unit length, outwards
  float intensity = 0;       ///< as in the cloud
  float weight = 0;          ///< sum over the averaged views of cos^2 of their slant
  int views = 0;             ///< that saw it, minus those that saw through it
};

/// Pose of an object relative to a camera.
struct Registration {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< object to camera frame
  std::size_t points = 0;  ///< number of the object's elements found in the cloud
  double share = 0;        ///< found / expected to be visible at that pose
  double rms = 0;          ///< of the distances along the surface normal, mm
};

/// Registers an object to a camera's organised cloud, starting from `guess`: iteratively minimises
/// the squared distances of its elements from the points of their pixels, along the sum of both
/// normals (iterative closest points; Rusinkiewicz 2019). Ignores points more than a few pixel
/// widths away or with another slope. Undetermined motion, such as a sphere's rotation, keeps the
/// guess. Uses at most about 10,000 elements, in equal steps. `normals`: of the cloud.
Registration register_to(std::span<const ModelElement> object, const Cloud& cloud,
                         const Normals& normals, const Lens& camera,
                         const Eigen::Isometry3d& guess);

/// Model of a rigid object that rotates and moves in front of a camera by no more than a few pixels
/// from view to view. Registers each cloud to the whole model, so that errors do not accumulate,
/// and averages it in. The clouds must contain only the object: a static background, such as a
/// wall, would become part of it. Not thread-safe.
class ObjectModel {
 public:
  /// `camera`: the lens of the clouds' camera.
  explicit ObjectModel(const Lens& camera) : camera_(camera) {}

  /// Adds a view at `time`, in any unit, later than the views before. Starts from uniform motion,
  /// or else from the last pose. Returns false and ignores the view if it does not fit the model or
  /// has too few points to begin one. The first view's frame is the object's. Throws Error if the
  /// cloud's size differs from the camera's.
  bool add(const Cloud& cloud, double time);

  [[nodiscard]] const std::vector<ModelElement>& elements() const { return elements_; }
  /// The elements seen by at least three views, or by all views if there are fewer.
  [[nodiscard]] ModelPoints points() const;
  [[nodiscard]] int views() const { return views_; }        ///< added
  [[nodiscard]] int left_out() const { return left_out_; }  ///< rejected
  /// Registration of the last view added.
  [[nodiscard]] const Registration& registration() const { return registration_; }

 private:
  struct Seen {
    double time = 0;
    Eigen::Isometry3d pose;
  };

  /// Extrapolates the motion between the last two views.
  [[nodiscard]] Eigen::Isometry3d expected_at(double time) const;
  [[nodiscard]] bool fits(const Registration& registration, const Cloud& cloud) const;
  /// Averages the view into the elements that it sees; returns the pixels that they cover.
  Image<std::uint8_t> take_mean(const Cloud& cloud, const Normals& normals);
  void add_uncovered(const Cloud& cloud, const Normals& normals,
                     const Image<std::uint8_t>& covered);

  Lens camera_;
  std::vector<ModelElement> elements_;
  Registration registration_;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();  // of the first view
  Seen before_last_, last_;                           // of the views added
  int views_ = 0, left_out_ = 0;
};

}  // namespace slipstream
