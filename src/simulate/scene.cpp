#include "slipstream/scene.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include <unsupported/Eigen/BVH>

#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

using Bounds = Eigen::AlignedBox3d;
using BoxTree = Eigen::KdBVH<double, 3, int>;

/// Query of Eigen's tree search: whether a box may contain, or a triangle is, a nearer hit.
struct NearestHit {
  const Mesh& mesh;
  const Ray& ray;
  Eigen::Array3d inverse = ray.direction.cwiseInverse();
  Hit hit{std::numeric_limits<double>::infinity(), Eigen::Vector3d::Zero()};

  bool intersectVolume(const Bounds& box) const {
    // Where the ray crosses each pair of the box's faces.
    const Eigen::Array3d a = (box.min() - ray.origin).array() * inverse;
    const Eigen::Array3d b = (box.max() - ray.origin).array() * inverse;
    const double enter = a.min(b).maxCoeff(), leave = a.max(b).minCoeff();
    return enter <= leave && leave > 0 && enter < hit.distance;
  }

  bool intersectObject(int index) {
    const auto& [i, j, k] = mesh.triangles[index];
    const Eigen::Vector3d& corner = mesh.vertices[i];
    const Eigen::Vector3d side_a = mesh.vertices[j] - corner;
    const Eigen::Vector3d side_b = mesh.vertices[k] - corner;
    const Eigen::Vector3d normal = side_a.cross(side_b);

    // 1. Where the ray meets the triangle's plane; a parallel ray misses it.
    const double facing = ray.direction.dot(normal);
    if (facing == 0) return false;

    const Eigen::Vector3d to_corner = corner - ray.origin;
    const double distance = to_corner.dot(normal) / facing;
    if (distance <= 0 || distance >= hit.distance) return false;

    // 2. Whether that is in the triangle: coordinates a and b along two of its sides.
    const Eigen::Vector3d moment = ray.direction.cross(to_corner);
    const double a = -side_b.dot(moment) / facing;
    const double b = side_a.dot(moment) / facing;
    if (a < 0 || b < 0 || a + b > 1) return false;

    // Never true, so that the search goes on to nearer triangles.
    hit = {distance, normal};
    return false;
  }
};

std::optional<Hit> hit(const Board& board, const Ray& ray) {
  const double distance = -ray.origin.z() / ray.direction.z();
  if (!(distance > 0)) return std::nullopt;

  const Eigen::Vector3d point = ray.origin + distance * ray.direction;
  const bool inside =
      2 * std::abs(point.x()) <= board.width && 2 * std::abs(point.y()) <= board.height;
  return inside ? std::optional<Hit>({distance, Eigen::Vector3d::UnitZ()}) : std::nullopt;
}

std::optional<Hit> hit(const Sphere& sphere, const Ray& ray) {
  const double a = ray.direction.squaredNorm();
  const double half_b = ray.origin.dot(ray.direction);

  // Distance of the ray from the centre by its nearest point: no cancellation for far spheres.
  const Eigen::Vector3d nearest = ray.origin - half_b / a * ray.direction;
  const double under_root = sphere.radius * sphere.radius - nearest.squaredNorm();

  if (under_root < 0) return std::nullopt;
  const double half_chord = std::sqrt(under_root / a);

  // The nearer crossing, or the farther one from within the sphere.
  for (const double distance : {-half_b / a - half_chord, -half_b / a + half_chord}) {
    if (distance > 0) return Hit{distance, ray.origin + distance * ray.direction};
  }

  return std::nullopt;
}

std::optional<Hit> hit(const Box& box, const Ray& ray) {
  const Eigen::Array3d half = box.size / 2, direction = ray.direction;
  // Where the ray crosses each pair of faces: it enters at the last of the near crossings.
  const Eigen::Array3d a = (-half - ray.origin.array()) / direction;
  const Eigen::Array3d b = (half - ray.origin.array()) / direction;
  int face = 0;
  const double enter = a.min(b).maxCoeff(&face), leave = a.max(b).minCoeff();

  if (enter > leave || enter <= 0) return std::nullopt;
  return Hit{enter, Eigen::Vector3d::Unit(face)};
}

std::optional<Hit> hit(const std::shared_ptr<const MeshTree>& tree, const Ray& ray) {
  return tree->first_hit(ray);
}

std::optional<Hit> hit(const PlacedBody& placed, const Ray& ray) {
  const Eigen::Affine3d& to_body = placed.to_body;
  const Ray in_body{to_body * ray.origin, to_body.linear() * ray.direction};
  return std::visit([&](const auto& shape) { return hit(shape, in_body); }, placed.body->shape);
}

constexpr float white = 255;

/// White outside the picture.
float grey_at(const Image<float>& picture, double column, double row) {
  const bool inside = column >= 0 && column < picture.width() && row >= 0 && row < picture.height();
  return inside ? picture(static_cast<int>(column), static_cast<int>(row)) : white;
}

/// Interpolates linearly between pixel centres, which are at integers.
double between_pixels(const Image<float>& picture, double column, double row) {
  const double left = std::floor(column), top = std::floor(row);
  const double right_share = column - left, bottom_share = row - top;

  const auto along = [&](double at_row) {
    return (1 - right_share) * grey_at(picture, left, at_row) +
           right_share * grey_at(picture, left + 1, at_row);
  };

  return (1 - bottom_share) * along(top) + bottom_share * along(top + 1);
}

/// Convolved with a Gaussian of standard deviation `deviation` pixels.
Image<float> blurred(const Image<std::uint8_t>& picture, double deviation) {
  Image<float> result(picture.size());
  std::ranges::copy(picture, result.begin());

  if (!(deviation > 0)) return result;
  const int reach = static_cast<int>(std::ceil(4 * deviation));

  std::vector<float> weights;
  for (int i = -reach; i <= reach; ++i) {
    weights.push_back(static_cast<float>(std::exp(-0.5 * std::pow(i / deviation, 2))));
  }

  const float sum = std::accumulate(weights.begin(), weights.end(), 0.0F);

  // The Gaussian is separable: along the rows, then along the columns.
  for (const auto& [right, down] : {std::pair(1, 0), std::pair(0, 1)}) {
    const Image<float> before = result;
    for_each_pixel_in_order(before.size(), [&](int column, int row) {
      float weighed = 0;
      for (int i = -reach; i <= reach; ++i) {
        weighed += weights[i + reach] * grey_at(before, column + i * right, row + i * down);
      }
      result(column, row) = weighed / sum;
    });
  }

  return result;
}

}  // namespace

struct MeshTree::Tree {
  BoxTree boxes;
};

void append_surface(Mesh& mesh, int rows, int columns,
                    const std::function<Eigen::Vector3d(double u, double v)>& point) {
  // The corners of the cells, row by row.
  const int first = static_cast<int>(mesh.vertices.size());
  for_each_pixel_in_order({columns + 1, rows + 1}, [&](int column, int row) {
    mesh.vertices.push_back(
        point(static_cast<double>(column) / columns, static_cast<double>(row) / rows));
  });

  // Two triangles for each cell.
  for_each_pixel_in_order({columns, rows}, [&](int column, int row) {
    const int corner = first + row * (columns + 1) + column;
    const int below = corner + columns + 1;
    mesh.triangles.push_back({corner, below, corner + 1});
    mesh.triangles.push_back({corner + 1, below, below + 1});
  });
}

MeshTree::MeshTree(Mesh mesh) : mesh_(std::move(mesh)) {
  if (mesh_.triangles.empty()) throw Error("the mesh has no triangles");

  std::vector<int> indices;
  std::vector<Bounds> boxes;
  for (const std::array<int, 3>& triangle : mesh_.triangles) {
    Bounds& box = boxes.emplace_back();
    for (const int corner : triangle) {
      throw_if(corner < 0 || static_cast<std::size_t>(corner) >= mesh_.vertices.size(),
               "a triangle of the mesh refers to vertex {} of {}", corner, mesh_.vertices.size());
      box.extend(mesh_.vertices[corner]);
    }
    indices.push_back(static_cast<int>(indices.size()));
  }

  tree_ = std::make_shared<const Tree>(
      Tree{BoxTree(indices.begin(), indices.end(), boxes.begin(), boxes.end())});
}

std::optional<Hit> MeshTree::first_hit(const Ray& ray) const {
  NearestHit nearest{mesh_, ray};
  Eigen::BVIntersect(tree_->boxes, nearest);
  return std::isinf(nearest.hit.distance) ? std::nullopt : std::optional(nearest.hit);
}

Texture uniform_texture(double alpha) {
  return [alpha](const Eigen::Vector3d&) { return alpha; };
}

Texture veined_texture(double darkest, double brightest, double scale) {
  return [=](const Eigen::Vector3d& p) {
    const Eigen::Vector3d q = p / scale;
    const double turbulence = std::sin(2.1 * q.x() + 1.3 * std::sin(1.7 * q.y())) +
                              std::sin(2.9 * q.y() + 1.1 * std::sin(2.3 * q.z() + q.x()));
    const double vein = std::abs(std::sin(1.5 * q.x() + q.y() + turbulence));
    return brightest - (brightest - darkest) * std::pow(1 - vein, 4);
  };
}

Texture picture_texture(const Image<std::uint8_t>& picture, double mm_per_pixel, double dark,
                        double bright, double blur) {
  const auto grey = std::make_shared<const Image<float>>(blurred(picture, blur / mm_per_pixel));
  const bool sharp = !(blur > 0);

  return [=](const Eigen::Vector3d& p) {
    const double column = p.x() / mm_per_pixel + grey->width() / 2.0 - 0.5;
    const double row = p.y() / mm_per_pixel + grey->height() / 2.0 - 0.5;
    const double white = sharp ? grey_at(*grey, std::round(column), std::round(row))
                               : between_pixels(*grey, column, row);
    return dark + (bright - dark) * white / 255;
  };
}

Eigen::Affine3d Motion::at(double time) const {
  time *= pace;
  const double angle = turn.norm() * time;
  const Eigen::Vector3d swayed = sway.at(time);

  // The body's own motion about its centre comes first, then its carrier's motion.
  const Eigen::Affine3d own = Eigen::Translation3d(centre + time * step + vibration.at(time)) *
                              Eigen::AngleAxisd(angle, turn.normalized()) *
                              Eigen::AngleAxisd(swayed.norm(), swayed.normalized()) *
                              Eigen::Scaling(1 + breathing.at(time)) *
                              Eigen::Translation3d(-centre);

  return carrier ? carrier->at(time) * own : own;
}

Motion moved_by(const Eigen::Isometry3d& change, Motion motion) {
  motion.centre = change * motion.centre;
  for (Eigen::Vector3d* direction :
       {&motion.step, &motion.turn, &motion.vibration.amplitude, &motion.sway.amplitude}) {
    *direction = change.linear() * *direction;
  }

  if (motion.carrier) {
    motion.carrier = std::make_shared<const Motion>(moved_by(change, *motion.carrier));
  }

  return motion;
}

Motion carried_by(const Motion& carrier, Motion motion) {
  if (carrier.is_none()) return motion;
  if (motion.is_none()) return carrier;
  motion.carrier = std::make_shared<const Motion>(
      motion.carrier ? carried_by(carrier, *motion.carrier) : carrier);
  return motion;
}

bool is_moving(const Scene& scene) {
  return std::ranges::any_of(scene, [](const Body& body) { return !body.motion.is_none(); });
}

std::optional<double> frames_of_a_turn(const Scene& scene) {
  std::optional<double> frames;
  for (const Body& body : scene) {
    const Motion& motion = body.motion;
    if (motion.is_none()) continue;

    // All moving bodies must turn equally, and do nothing else.
    const double turn = 2 * std::numbers::pi / (motion.pace * motion.turn.norm());
    if (!motion.only_turns() || turn != frames.value_or(turn)) return std::nullopt;
    frames = turn;
  }
  return frames;
}

double frames_of_a_sway(const Scene& scene) {
  double longest = 0;

  for (const Body& body : scene) {
    const Swing<Eigen::Vector3d>& sway = body.motion.sway;
    if (!sway.amplitude.isZero(0)) longest = std::max(longest, sway.period / body.motion.pace);
  }

  return longest;
}

std::vector<PlacedBody> placed_at(const Scene& scene, double time) {
  std::vector<PlacedBody> placed;

  for (const Body& body : scene) {
    Eigen::Affine3d pose(body.pose);
    if (!body.motion.is_none()) pose = body.motion.at(time) * body.pose;
    placed.push_back({&body, pose, pose.inverse()});
  }

  return placed;
}

std::optional<SurfacePoint> first_surface(const std::vector<PlacedBody>& bodies, const Ray& ray) {
  const PlacedBody* nearest = nullptr;
  Hit first{.distance = std::numeric_limits<double>::infinity(), .normal = {}};

  for (const PlacedBody& body : bodies) {
    const std::optional<Hit> found = hit(body, ray);
    if (!found || found->distance >= first.distance) continue;
    nearest = &body;
    first = *found;
  }
  if (nearest == nullptr) return std::nullopt;

  const Body& met = *nearest->body;
  const Eigen::Vector3d point = ray.origin + first.distance * ray.direction;
  Eigen::Vector3d normal = (nearest->pose.linear() * first.normal).normalized();
  if (normal.dot(ray.direction) > 0) normal = -normal;
  return SurfacePoint{first.distance, point,    normal, met.texture(nearest->to_body * point),
                      met.shading,    met.gloss};
}

bool in_shadow(const std::vector<PlacedBody>& bodies, const Eigen::Vector3d& point,
               const Eigen::Vector3d& light) {
  // From the light towards the point; its own surface is at distance 1, within rounding.
  constexpr double own_surface = 1 - 1e-6;
  const Ray ray{light, point - light};
  return std::ranges::any_of(bodies, [&](const PlacedBody& body) {
    const std::optional<Hit> found = hit(body, ray);
    return found && found->distance < own_surface;
  });
}

}  // namespace slipstream
