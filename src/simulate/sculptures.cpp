#include "simulate/sculptures.h"

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

/// Distance of the head's surface from its centre in a direction.
double head_radius(const Vector& d) {
  double radius = 1;
  // The face.
  radius += 0.30 * bump(d, {0, -0.12, 1}, 0.11, 0.17);     // nose
  radius += 0.06 * bump(d, {0, 0.02, 1}, 0.07, 0.22);      // its bridge
  radius += 0.07 * bump(d, {0, 0.28, 0.95}, 0.45, 0.09);   // brow
  radius += 0.12 * bump(d, {0, -0.78, 0.75}, 0.22, 0.16);  // chin
  radius -= 0.05 * bump(d, {0, -0.44, 0.9}, 0.17, 0.03);   // mouth
  radius += 0.05 * bump(d, {0, -0.52, 0.9}, 0.15, 0.05);   // lower lip

  // Eyes, cheeks and ears on both sides.
  for (const double side : {-1.0, 1.0}) {
    radius -= 0.12 * bump(d, {side * 0.32, 0.08, 0.95}, 0.15, 0.10);  // eye socket
    radius += 0.05 * bump(d, {side * 0.31, 0.07, 0.95}, 0.07, 0.05);  // eye
    radius += 0.06 * bump(d, {side * 0.48, -0.22, 0.85}, 0.2, 0.2);   // cheek
    radius += 0.16 * bump(d, {side, -0.02, -0.02}, 0.10, 0.22);       // ear
  }

  // Hair from the forehead to the neck, in strands.
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
  // Two smooth steps: the neck widens to the shoulders, which narrow to the foot.
  const double y = 0.15 - 0.65 * v;
  const double shoulder = 1 / (1 + std::exp((y + 0.085) * 42));
  const double foot = 1 / (1 + std::exp((y + 0.33) * 30));

  const double width = 0.085 + 0.27 * shoulder - 0.13 * foot;
  const double depth = 0.085 + 0.09 * shoulder - 0.03 * foot;

  // Folds that fade towards the foot.
  const double angle = 2 * pi * u;
  const double folds = 1 + 0.03 * shoulder * (1 - foot) * std::sin(15 * angle + 9 * y);

  return {folds * width * std::sin(angle), y, folds * depth * std::cos(angle) - 0.02};
}

/// A ring in front of the chest, which occludes and shades it.
Vector ring(double u, double v) {
  const double around = 2 * pi * u, across = 2 * pi * v;
  const double from_middle = 0.13 + 0.022 * std::cos(across);
  return {from_middle * std::cos(around) + 0.02, from_middle * std::sin(around) - 0.16,
          0.26 + 0.022 * std::sin(across) + 0.05 * std::cos(around)};
}

/// The statue's head, smaller, on the angel's neck.
Vector angel_head(double u, double v) {
  return 0.45 * (head(u, v) - Vector(0, 0.27, 0)) + Vector(0, 0.33, 0.02);
}

/// Neck, shoulders and a robe that widens to its hem in deepening pleats.
Vector robe(double u, double v) {
  // The neck widens to the shoulders, and the robe below them to its hem.
  const double y = 0.27 - 0.77 * v;
  const double shoulder = 1 / (1 + std::exp((y - 0.2) * 60));
  const double skirt = std::clamp((0.1 - y) / 0.6, 0.0, 1.0);
  const double radius = 0.035 + 0.085 * shoulder + 0.12 * std::pow(skirt, 1.5);

  // Pleats that deepen to the hem.
  const double angle = 2 * pi * u;
  const double pleats = 1 + 0.07 * skirt * std::sin(16 * angle + 3 * y);

  return {pleats * radius * std::sin(angle), y, 0.75 * pleats * radius * std::cos(angle)};
}

/// A raised wing behind the shoulder, with a rib along each feather. `side`: -1 or 1.
Vector wing(double side, double u, double v) {
  const double top = 0.17 + 0.29 * std::sin(0.6 * pi * u) - 0.05 * u;
  const double bottom = -0.22 + 0.5 * u * u - 0.025 * std::abs(std::sin(7 * pi * u));
  const double ribs = 0.012 * v * std::sin(14 * pi * u);
  return {side * (0.05 + 0.37 * u), top + (bottom - top) * v, -0.07 - 0.1 * u * u + ribs};
}

/// A thin ring above the head, tilted towards the viewer.
Vector halo(double u, double v) {
  const double around = 2 * pi * u, across = 2 * pi * v;
  const double from_middle = 0.085 + 0.011 * std::cos(across);
  const double out = from_middle * std::sin(around);
  return {from_middle * std::cos(around), 0.45 + 0.4 * out + 0.011 * std::sin(across), 0.9 * out};
}

/// Half of the fish's height, at a share u of the way from its mouth to its tail.
double fish_half_height(double u) {
  return 0.21 * std::pow(std::sin(pi * std::pow(u, 0.75)), 0.8) + 0.04 * u;
}

/// Distance of the mouth and of the root of the tail from the middle.
constexpr double mouth = -0.5, tail_root = 0.32;

double along_fish(double u) {
  return mouth + (tail_root - mouth) * u;
}

/// The side of the body that the viewer sees, from the back to the belly.
Vector fish_body(double u, double v) {
  const double height = fish_half_height(u), angle = pi * v;
  return {along_fish(u), height * std::cos(angle), 0.65 * height * std::sin(angle)};
}

/// A fan that spreads to the right, with a notch in its end.
Vector tail_fin(double u, double v) {
  const double from_middle = 2 * v - 1;
  const double length = 0.19 * (0.65 + 0.35 * from_middle * from_middle);
  return {tail_root - 0.02 + length * u, from_middle * (0.035 + 0.17 * u),
          0.03 * (1 - u) + 0.008 * std::sin(18 * pi * v)};
}

/// A fin that rises from the back, leaning to the tail.
Vector back_fin(double u, double v) {
  const double height = 0.11 * std::sin(pi * u) * v;
  const double root = fish_half_height(0.3 + 0.45 * u) - 0.02;
  return {along_fish(0.3 + 0.45 * u) + 0.6 * height, root + height,
          0.02 + 0.006 * std::sin(20 * pi * u) * v};
}

/// A fin that stands off the side behind the gills.
Vector side_fin(double u, double v) {
  const double from_middle = 2 * v - 1;
  return {-0.17 + 0.16 * u, -0.05 - 0.05 * u + 0.055 * u * from_middle,
          0.13 + 0.035 * u + 0.005 * std::sin(10 * pi * v)};
}

}  // namespace

Mesh statue() {
  Mesh mesh;
  append_surface(mesh, 150, 200, head);
  append_surface(mesh, 70, 140, torso);
  append_surface(mesh, 20, 90, ring);
  return mesh;
}

Mesh angel() {
  Mesh mesh;
  append_surface(mesh, 90, 120, angel_head);
  append_surface(mesh, 120, 200, robe);
  append_surface(mesh, 12, 60, halo);

  for (const double side : {-1.0, 1.0}) {
    append_surface(mesh, 40, 90, [side](double u, double v) { return wing(side, u, v); });

    // The arms are folded, with the hands together in front of the chest.
    const LimbEnd shoulder{{0.11 * side, 0.16, 0.02}, 0.035};
    const LimbEnd elbow{{0.14 * side, 0.02, 0.08}, 0.035};
    const LimbEnd wrist{{0.025 * side, 0.08, 0.15}, 0.025};
    const LimbEnd fingers{{0.012 * side, 0.16, 0.16}, 0.013};
    append_limb(mesh, shoulder, elbow);
    append_limb(mesh, elbow, wrist);
    append_limb(mesh, wrist, fingers);
  }

  return mesh;
}

Mesh fish() {
  Mesh mesh;
  append_surface(mesh, 80, 160, fish_body);
  append_surface(mesh, 60, 30, tail_fin);
  append_surface(mesh, 20, 60, back_fin);
  append_surface(mesh, 30, 20, side_fin);
  append_ellipsoid(mesh, {-0.36, 0.035, 0.082}, {0.027, 0.027, 0.02});

  return mesh;
}

Texture fish_paint(double length) {
  return [length](const Vector& p) {
    const double x = p.x() / length, y = p.y() / length;
    if (std::hypot(x + 0.36, y - 0.035) < 0.014) return 0.3;  // pupil

    const double scales = std::abs(std::sin(45 * (x + y)) * std::sin(45 * (x - y)));
    const double bands = 0.5 + 0.5 * std::sin(30 * x + 4 * y);
    const double back = 1 / (1 + std::exp((0.06 - y) * 60));

    return std::clamp(0.45 + 0.2 * scales + 0.25 * bands - 0.15 * back, 0.3, 0.9);
  };
}

void append_limb(Mesh& mesh, const LimbEnd& from, const LimbEnd& to) {
  const Vector along = (to.centre - from.centre).normalized();
  const Vector side = along.unitOrthogonal(), other = along.cross(side);

  // Two half spheres; an odd number of rows puts one row of cells, the limb, between them.
  append_surface(mesh, 17, 28, [&](double u, double v) -> Vector {
    const double around = 2 * pi * u, latitude = pi * v;
    const LimbEnd& end = v < 0.5 ? from : to;
    const Vector outwards = std::cos(around) * side + std::sin(around) * other;
    return end.centre + end.radius * (std::sin(latitude) * outwards - std::cos(latitude) * along);
  });
}

void append_ellipsoid(Mesh& mesh, const Vector& centre, const Vector& radii) {
  append_surface(mesh, 30, 40, [&](double u, double v) -> Vector {
    const double longitude = 2 * pi * u, latitude = pi * v;
    const Vector outwards(std::sin(latitude) * std::sin(longitude), std::cos(latitude),
                          std::sin(latitude) * std::cos(longitude));
    return centre + radii.cwiseProduct(outwards);
  });
}

}  // namespace slipstream
