#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include "slipstream/image.h"

namespace slipstream {

/// The points origin + distance direction, distance > 0. Distances are in units of `direction`, so
/// that they are depths along a camera ray (u, v, 1).
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

/// Triangles by the indices of their corners. Units and axes depend on the source.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
};

/// Adds the surface point(u, v), u and v in [0, 1], as `rows` x `columns` cells of two triangles.
void append_surface(Mesh& mesh, int rows, int columns,
                    const std::function<Eigen::Vector3d(double u, double v)>& point);

class TriangleTree;

/// A mesh for ray tracing: its triangles in a tree of boxes.
class MeshTree {
 public:
  /// Throws Error without triangles, or if one refers to a missing vertex.
  explicit MeshTree(const Mesh& mesh);

  /// For packets of rays.
  [[nodiscard]] const TriangleTree& triangles() const { return *tree_; }

 private:
  std::shared_ptr<const TriangleTree> tree_;
};

/// A flat sheet in the plane z = 0, centred on the origin; mm.
struct Board {
  double width = 0, height = 0;
};

/// Centred on the origin; mm.
struct Sphere {
  double radius = 0;
};

/// Centred on the origin, sides along the axes; mm.
struct Box {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
};

using Shape = std::variant<Board, Sphere, Box, std::shared_ptr<const MeshTree>>;

/// Reflectivity, in [0, 1], at a point of the body's own frame.
using Texture = std::function<double(const Eigen::Vector3d&)>;

Texture uniform_texture(double alpha);

/// Dark and light veins between the two reflectivities, that repeat about every `scale` mm.
Texture veined_texture(double darkest, double brightest, double scale);

/// A grey picture in the plane z = 0, centred on the origin, rows along X and columns along Y:
/// black has reflectivity `dark`, white and the surroundings `bright`. Each pixel is a square of
/// `mm_per_pixel`. Blurred by a Gaussian of standard deviation `blur` mm, 0: not at all.
Texture picture_texture(const Image<std::uint8_t>& picture, double mm_per_pixel, double dark,
                        double bright, double blur = 0);

/// How reflectivity depends on the angle of the projector's light.
enum class Shading {
  none,        ///< alpha is the texture's
  lambertian,  ///< alpha is the texture's times the cosine between normal and light
};

/// A sinusoidal oscillation; amplitude 0 by default.
template <class Value>
struct Swing {
  Value amplitude{};
  double period = 1;  ///< frames

  [[nodiscard]] Value at(double time) const {
    return std::sin(2 * std::numbers::pi * time / period) * amplitude;
  }
};

/// Motion of a body in the camera's frame; all components combine. None by default.
struct Motion {
  Eigen::Vector3d step = Eigen::Vector3d::Zero();  ///< mm from one frame to the next
  /// Rotation about `centre`: axis times angle, rad from one frame to the next.
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  Swing<Eigen::Vector3d> vibration{Eigen::Vector3d::Zero()};  ///< mm
  Swing<double> breathing{0};                                 ///< relative growth
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of turns and breathing at time 0, mm
  double pace = 1;                                   ///< factor for all of these
  /// Rotation about `centre` that swings to and fro: axis times angle, rad.
  Swing<Eigen::Vector3d> sway{Eigen::Vector3d::Zero()};
  /// Motion of the part that carries this one, as a finger carries its tip. May be null.
  std::shared_ptr<const Motion> carrier{};

  /// Maps a point of the body at time 0 to its position at `time`, frames.
  [[nodiscard]] Eigen::Affine3d at(double time) const;

  [[nodiscard]] bool only_turns() const {
    return step.isZero(0) && vibration.amplitude.isZero(0) && breathing.amplitude == 0 &&
           sway.amplitude.isZero(0) && !carrier;
  }
  [[nodiscard]] bool is_none() const { return only_turns() && turn.isZero(0); }
};

/// The same motion after the body and all that carries it are moved by `change`, in which
/// directions turn and points also shift.
Motion moved_by(const Eigen::Isometry3d& change, Motion motion);

/// The motion of a part whose outermost carrier is itself carried by `carrier`.
Motion carried_by(const Motion& carrier, Motion motion);

/// An object in the scene.
struct Body {
  Shape shape;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< own frame to camera frame
  Texture texture = uniform_texture(0.8);
  Shading shading = Shading::none;
  /// Specular part of alpha: times the 30th power of the cosine between the normal and the
  /// half-way direction of light and camera.
  double gloss = 0;
  Motion motion{};
  bool fixed = false;  ///< stays still when motion is applied to the scene
};

using Scene = std::vector<Body>;

/// The surface that a ray meets first.
struct SurfacePoint {
  double distance = 0;     ///< in units of the ray's direction
  Eigen::Vector3d point;   ///< camera frame, mm
  Eigen::Vector3d normal;  ///< unit length, against the ray
  double alpha = 0;        ///< reflectivity of the texture
  Shading shading = Shading::none;
  double gloss = 0;
};

bool is_moving(const Scene& scene);

/// Frames per full turn if the scene only rotates; nullopt otherwise.
std::optional<double> frames_of_a_turn(const Scene& scene);

/// Longest period of the bodies' swaying, frames; 0 if none sways.
double frames_of_a_sway(const Scene& scene);

/// A body where it is at one moment. Borrows the body.
struct PlacedBody {
  const Body* body;
  Eigen::Affine3d pose;     ///< own frame to camera frame
  Eigen::Affine3d to_body;  ///< its inverse
};

/// The scene at `time`, in frames (0 at the first). Borrows the scene.
std::vector<PlacedBody> placed_at(const Scene& scene, double time);
std::vector<PlacedBody> placed_at(Scene&& scene, double time) = delete;

std::optional<SurfacePoint> first_surface(const std::vector<PlacedBody>& bodies, const Ray& ray);

}  // namespace slipstream
