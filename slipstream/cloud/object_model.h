#pragma once

#include <span>

#include <Eigen/Geometry>

#include "slipstream/cloud/surface.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// A small piece of an object's surface, in the object's frame.
struct ModelElement {
  Eigen::Vector3f position;  ///< mm
  Eigen::Vector3f normal;    ///< unit length, outwards
  float intensity = 0;       ///< as the cloud's
  float weight = 0;  ///< of the views that it is the mean of: each counts cos^2 of its slant
  int views = 0;     ///< in which it was seen, less those that saw through it
};

/// Where an object stands before a camera.
struct Registration {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< the object's frame to the camera's
  std::size_t points = 0;  ///< of the object that were found in the cloud
  double share = 0;        ///< of those that should be seen at that pose
  double rms = 0;          ///< of their distances along the surface's normal, mm
};

/// Poses an object from near `guess` to a camera's organised cloud: the squared distances of its
/// elements from the points of their pixels, along the sum of both normals, are made least, round
/// by round (iterative closest points; Rusinkiewicz 2019). Pixels more than a few pixels' width off
/// or of another slope do not count. What the form leaves open, as turns of a sphere, stays as
/// guessed. Looks at some 10,000 elements at most, in even steps. `normals`: of the cloud.
Registration register_to(std::span<const ModelElement> object, const Cloud& cloud,
                         const Normals& normals, const Lens& camera,
                         const Eigen::Isometry3d& guess);

/// The points of a model with their normals: of one row, in the object's frame.
struct ModelPoints {
  Cloud cloud;
  Normals normals;
};

/// The model of a rigid object that turns and moves before a camera by less than some pixels from
/// view to view: each cloud is registered to all that is known of the object, so that errors do not
/// add up, and taken into its mean. The clouds must show the object alone: what stands still beside
/// it, as a wall, becomes a part of it. One thread uses it.
class ObjectModel {
 public:
  /// The lens that the clouds are seen through.
  explicit ObjectModel(const Lens& camera) : camera_(camera) {}

  /// Takes in a view seen at `time`, in any unit, later than those before: where even motion has
  /// brought the object, or else where it was. False, and nothing taken, where it does not fit the
  /// model or has too few points to begin one. The first view's frame is the object's. Throws Error
  /// where the cloud is not of the camera's size.
  bool add(const Cloud& cloud, double time);

  [[nodiscard]] const std::vector<ModelElement>& elements() const { return elements_; }
  /// Those that three views have seen, or all views where they are fewer.
  [[nodiscard]] ModelPoints points() const;
  [[nodiscard]] int views() const { return views_; }        ///< taken in
  [[nodiscard]] int left_out() const { return left_out_; }  ///< that did not fit
  /// Of the last view that was taken in.
  [[nodiscard]] const Registration& registration() const { return registration_; }

 private:
  struct Seen {
    double time = 0;
    Eigen::Isometry3d pose;
  };

  /// If it went on as between the last two views.
  [[nodiscard]] Eigen::Isometry3d expected_at(double time) const;
  [[nodiscard]] bool fits(const Registration& registration, const Cloud& cloud) const;
  /// Takes the view into the mean of the elements that it sees; returns which pixels they cover.
  Image<std::uint8_t> take_mean(const Cloud& cloud, const Normals& normals);
  void add_uncovered(const Cloud& cloud, const Normals& normals,
                     const Image<std::uint8_t>& covered);

  Lens camera_;
  std::vector<ModelElement> elements_;
  Registration registration_;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();  // of the first view
  Seen before_last_, last_;                           // of the views that were taken in
  int views_ = 0, left_out_ = 0;
};

}  // namespace slipstream
