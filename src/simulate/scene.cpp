#include "slipstream/scene.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "simulate/ray_packet.h"
#include "simulate/surface_packet.h"
#include "simulate/triangle_tree.h"

namespace slipstream {
namespace {

/// A packet of which only the first ray is traced.
struct OneRay {
  explicit OneRay(const Ray& ray) {
    for (int i = 0; i < packet_rays; ++i) directions.set(i, ray.direction);
    limit.fill(-1);
    limit[0] = std::numeric_limits<double>::infinity();
  }

  LaneVectors directions;
  Lanes limit;
};

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

MeshTree::MeshTree(const Mesh& mesh) : tree_(std::make_shared<const TriangleTree>(mesh)) {}

Texture uniform_texture(double alpha) {
  return [alpha](const Eigen::Vector3d&) { return alpha; };
}

Texture veined_texture(double darkest, double brightest, double scale) {
  return VeinedTexture{darkest, brightest, scale};
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
  const OneRay one(ray);
  const PacketHits hits = first_hits(bodies, ray.origin, one.directions, one.limit);
  if (hits.body[0] < 0) return std::nullopt;

  const PacketSurfaces surfaces = surfaces_of(bodies, hits, ray.origin, one.directions);
  return SurfacePoint{hits.distance[0],
                      surfaces.point.at(0),
                      surfaces.normal.at(0),
                      surfaces.alpha[0],
                      bodies[hits.body[0]].body->shading,
                      surfaces.gloss[0]};
}

}  // namespace slipstream
