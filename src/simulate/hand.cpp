#include "simulate/hand.h"

#include <memory>
#include <vector>

#include "base/numbers.h"
#include "simulate/sculptures.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;

/// A finger or the thumb, in the hand's own frame.
struct Digit {
  Vector root;                  ///< its first joint
  Vector direction;             ///< stretched out
  std::vector<double> lengths;  ///< of its phalanges, from the root on
  double radius = 0;            ///< at the root; the tip has three quarters of it
  double bends = 1;             ///< in a period of the hand's motion
};

std::vector<Digit> digits() {
  return {{{-0.18, -0.14, 0.05}, {-0.6, 0.7, 0.35}, {0.15, 0.12}, 0.058, 3},
          {{-0.145, 0.06, 0}, {-0.12, 1, 0}, {0.17, 0.105, 0.085}, 0.05, 1},
          {{-0.045, 0.085, 0}, {-0.02, 1, 0}, {0.185, 0.125, 0.09}, 0.052, 1},
          {{0.055, 0.07, 0}, {0.07, 1, 0}, {0.175, 0.115, 0.09}, 0.049, 1},
          {{0.145, 0.02, 0}, {0.18, 1, 0}, {0.135, 0.08, 0.075}, 0.042, 1}};
}

/// Builds the bodies of one hand.
class HandBuilder {
 public:
  HandBuilder(double size, const Eigen::Isometry3d& pose) : size_(size), pose_(pose) {}

  /// A rotation about a joint that swings by `angle` to either side. The axis is in the hand's
  /// frame.
  [[nodiscard]] Motion swinging(const Vector& joint, const Vector& axis, double angle,
                                double times) const {
    return {.centre = pose_ * (size_ * joint),
            .sway = {angle * (pose_.linear() * axis), hand_period / times}};
  }

  void add(Mesh mesh, const Motion& motion) {
    for (Vector& vertex : mesh.vertices) vertex *= size_;

    scene_.push_back(Body{.shape = std::make_shared<const MeshTree>(mesh),
                          .pose = pose_,
                          .texture = uniform_texture(0.75),
                          .shading = Shading::lambertian,
                          .motion = motion});
  }

  /// Adds the phalanges of a digit; each is carried by the one before, the first by the palm.
  void add(const Digit& digit, std::shared_ptr<const Motion> carrier) {
    constexpr double bend = 16 * degree;  // of each joint, in the middle of its swing
    const Vector axis = digit.direction.cross(Vector::UnitZ()).normalized();

    const double thinner = 0.25 * digit.radius / static_cast<double>(digit.lengths.size());

    LimbEnd joint{digit.root, digit.radius};
    Vector direction = digit.direction.normalized();
    for (const double length : digit.lengths) {
      direction = Eigen::AngleAxisd(bend, axis) * direction;
      const LimbEnd next{joint.centre + length * direction, joint.radius - thinner};
      Mesh phalanx;
      append_limb(phalanx, joint, next);

      Motion motion = swinging(joint.centre, axis, bend, digit.bends);
      motion.carrier = carrier;
      add(std::move(phalanx), motion);
      carrier = std::make_shared<const Motion>(motion);
      joint = next;
    }
  }

  [[nodiscard]] Scene scene() && { return std::move(scene_); }

 private:
  double size_;
  Eigen::Isometry3d pose_;
  Scene scene_;
};

}  // namespace

Scene hand(double size, const Eigen::Isometry3d& pose) {
  HandBuilder builder(size, pose);

  // The wrist carries all: it turns about the forearm and moves to and fro along the view.
  const Vector wrist(0, -0.36, 0);
  Motion of_wrist = builder.swinging(wrist, Vector::UnitY(), 14 * degree, 1);
  of_wrist.vibration = {Vector(0, 0, 0.12 * size), hand_period};

  Mesh palm;
  append_ellipsoid(palm, {0, -0.12, 0}, {0.205, 0.235, 0.075});
  append_limb(palm, {{-0.02, -0.3, 0}, 0.095}, {{-0.02, -0.55, -0.03}, 0.09});
  append_limb(palm, {{-0.06, -0.26, 0.01}, 0.09}, {{-0.15, -0.13, 0.04}, 0.062});
  builder.add(std::move(palm), of_wrist);

  const auto carrier = std::make_shared<const Motion>(of_wrist);
  for (const Digit& digit : digits()) builder.add(digit, carrier);
  return std::move(builder).scene();
}

}  // namespace slipstream
