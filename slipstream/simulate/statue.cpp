#include "slipstream/simulate/statue.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slipstream {
namespace {

using std::numbers::pi;
using Vector = Eigen::Vector3d;

/// A round bump of height 1 at `centre`, on the unit sphere of directions.
double bump(const Vector& direction, const Vector& centre, double width, double height) {
  const Vector offset = direction - centre.normalized();
  return std::exp(-(offset.x() * offset.x() + offset.z() * offset.z()) / (width * width) -
                  offset.y() * offset.y() / (height * height));
}

/// How far from the middle of the head its surface lies in a direction.
double head_radius(const Vector& d) {
  double radius = 1;
  radius += 0.30 * bump(d, {0, -0.12, 1}, 0.11, 0.17);     // nose
  radius += 0.06 * bump(d, {0, 0.02, 1}, 0.07, 0.22);      // its bridge
  radius += 0.07 * bump(d, {0, 0.28, 0.95}, 0.45, 0.09);   // brow
  radius += 0.12 * bump(d, {0, -0.78, 0.75}, 0.22, 0.16);  // chin
  radius -= 0.05 * bump(d, {0, -0.44, 0.9}, 0.17, 0.03);   // mouth
  radius += 0.05 * bump(d, {0, -0.52, 0.9}, 0.15, 0.05);   // lower lip
  for (const double side : {-1.0, 1.0}) {
    radius -= 0.12 * bump(d, {side * 0.32, 0.08, 0.95}, 0.15, 0.10);  // eye socket
    radius += 0.05 * bump(d, {side * 0.31, 0.07, 0.95}, 0.07, 0.05);  // eye
    radius += 0.06 * bump(d, {side * 0.48, -0.22, 0.85}, 0.2, 0.2);   // cheek
    radius += 0.16 * bump(d, {side, -0.02, -0.02}, 0.10, 0.22);       // ear
  }
  const double hair = std::clamp((d.y() - 0.25 + 0.6 * std::min(-d.z(), 0.4)) * 6, 0.0, 1.0);
  return radius + hair * (0.07 + 0.025 * std::sin(26 * std::atan2(d.x(), d.y() + 0.4)));
}

Vector head(double u, double v) {
  const double longitude = 2 * pi * u, latitude = pi * v;
  const Vector direction(std::sin(latitude) * std::sin(longitude), std::cos(latitude),
                         std::sin(latitude) * std::cos(longitude));
  return head_radius(direction) * direction.cwiseProduct(Vector(0.165, 0.215, 0.19)) +
         Vector(0, 0.27, 0);
}

/// Neck, shoulders and foot: an oval that widens and narrows from top to bottom.
Vector torso(double u, double v) {
  const double y = 0.15 - 0.65 * v;
  const double shoulder = 1 / (1 + std::exp((y + 0.085) * 42));
  const double foot = 1 / (1 + std::exp((y + 0.33) * 30));
  const double width = 0.085 + 0.27 * shoulder - 0.13 * foot;
  const double depth = 0.085 + 0.09 * shoulder - 0.03 * foot;
  const double angle = 2 * pi * u;
  const double folds = 1 + 0.03 * shoulder * (1 - foot) * std::sin(15 * angle + 9 * y);
  return {folds * width * std::sin(angle), y, folds * depth * std::cos(angle) - 0.02};
}

/// A tube bent to a ring that stands before the chest, so that it hides and shades what is behind.
Vector ring(double u, double v) {
  const double around = 2 * pi * u, across = 2 * pi * v;
  const double from_middle = 0.13 + 0.022 * std::cos(across);
  return {from_middle * std::cos(around) + 0.02, from_middle * std::sin(around) - 0.16,
          0.26 + 0.022 * std::sin(across) + 0.05 * std::cos(around)};
}

}  // namespace

Mesh statue() {
  Mesh mesh;
  append_surface(mesh, 150, 200, head);
  append_surface(mesh, 70, 140, torso);
  append_surface(mesh, 20, 90, ring);
  return mesh;
}

}  // namespace slipstream
