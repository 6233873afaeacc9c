#include "slipstream/view/axes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace slipstream::view {
namespace {

constexpr glm::vec3 blue(0.36F, 0.60F, 1.0F), green(0.35F, 0.85F, 0.42F), red(1.0F, 0.38F, 0.34F);

/// Strokes of a letter in a square from -1 to 1, Y up.
struct Stroke {
  float from_x, from_y, to_x, to_y;
};
constexpr std::array<Stroke, 2> letter_x{{{-0.7F, 1, 0.7F, -1}, {-0.7F, -1, 0.7F, 1}}};
constexpr std::array<Stroke, 3> letter_y{
    {{-0.7F, 1, 0, 0.05F}, {0.7F, 1, 0, 0.05F}, {0, 0.05F, 0, -1}}};
constexpr std::array<Stroke, 3> letter_z{
    {{-0.7F, 1, 0.7F, 1}, {0.7F, 1, -0.7F, -1}, {-0.7F, -1, 0.7F, -1}}};

/// The directions of the picture in the scanner's frame.
struct Facing {
  glm::vec3 right;
  glm::vec3 up;
};

Facing facing(const OrbitCamera& camera) {
  const glm::mat4 view = view_matrix(camera);
  return {in_display_frame({view[0][0], view[1][0], view[2][0]}),
          in_display_frame({view[0][1], view[1][1], view[2][1]})};
}

void add_letter(std::vector<Line>& lines, std::span<const Stroke> strokes, const glm::vec3& at,
                float size, const Facing& facing, const glm::vec3& colour) {
  const auto place = [&](float x, float y) {
    return at + size * (x * facing.right + y * facing.up);
  };
  for (const Stroke& stroke : strokes) {
    lines.push_back(
        {place(stroke.from_x, stroke.from_y), place(stroke.to_x, stroke.to_y), colour, 1});
  }
}

}  // namespace

std::vector<Line> axes(const Box& box, const OrbitCamera& camera) {
  const glm::vec3 sides = box.high - box.low;
  const glm::vec3 origin(box.low.x, box.high.y, box.low.z);
  const float length = 0.3F * std::max({sides.x, sides.y, sides.z});
  const float letter = 0.009F * camera.distance;
  const Facing towards = facing(camera);
  std::vector<Line> lines;
  const auto add = [&](const glm::vec3& direction, std::span<const Stroke> strokes,
                       const glm::vec3& colour) {
    const glm::vec3 end = origin + length * direction;
    lines.push_back({origin, end, colour, 1});
    add_letter(lines, strokes, end + 1.9F * letter * direction, letter, towards, colour);
  };
  add({1, 0, 0}, letter_x, blue);
  add({0, 1, 0}, letter_y, green);
  add({0, 0, 1}, letter_z, red);
  return lines;
}

float grid_step(const Box& box) {
  const float wanted = std::max(box.diagonal(), 1e-3F) / 10;
  const float power = std::pow(10.0F, std::floor(std::log10(wanted)));
  for (const float factor : {1.0F, 2.0F, 5.0F}) {
    if (wanted <= factor * power) return factor * power;
  }
  return 10 * power;
}

std::vector<Line> floor_grid(const Box& box, float height) {
  constexpr glm::vec3 colour(0.62F, 0.66F, 0.72F);
  constexpr float opacity = 0.28F;
  const float step = grid_step(box), margin = 2 * step;
  const auto first = [&](float low) { return std::floor((low - margin) / step) * step; };
  const auto last = [&](float high) { return std::ceil((high + margin) / step) * step; };
  const float left = first(box.low.x), right = last(box.high.x);
  const float front = first(box.low.z), back = last(box.high.z);
  // Counted: far from the origin a step may be lost in the rounding of what it is added to.
  const auto count = [&](float from, float to) {
    constexpr float most = 64;
    return static_cast<int>(std::clamp(std::round((to - from) / step) + 1, 0.0F, most));
  };
  std::vector<Line> lines;
  for (int i = 0; i < count(left, right); ++i) {
    const float x = left + static_cast<float>(i) * step;
    lines.push_back({{x, height, front}, {x, height, back}, colour, opacity});
  }
  for (int i = 0; i < count(front, back); ++i) {
    const float z = front + static_cast<float>(i) * step;
    lines.push_back({{left, height, z}, {right, height, z}, colour, opacity});
  }
  return lines;
}

}  // namespace slipstream::view
