#version 450
#extension GL_GOOGLE_include_directive : require
// Coordinates to points, confirmed by their neighbours: StripeGeometry and FringeOrderConsensus, as
// the row kernels compute them.
layout(local_size_x = 64) in;

#include "stages.glsl"

layout(std430, binding = 2) readonly buffer Rays { float rays[]; };  // E_x and E_y in turns of four
layout(std430, binding = 3) readonly buffer Between { uint between[]; };
layout(std430, binding = 4) writeonly buffer Output { uvec4 planes[]; };
layout(std430, binding = 5) writeonly buffer Reasons { uint reasons[]; };

// Of Validity.
const uint valid = 0u, too_dark = 1u, is_saturated = 2u, doubtful = 3u, no_point = 4u,
           outside_field = 5u, out_of_range = 6u;

float coordinate_at(int at) { return uintBitsToFloat(between[at / 4 * 8 + at % 4]); }
int flags_at(int at) { return int(between[at / 4 * 8 + 4 + at % 4]); }

bool is_confirmed(int at, float y, int flags) {
  if (points.confirmed == 0) return true;
  int needed = (flags & doubtful_order) != 0 ? points.fewest_if_doubtful : points.fewest_neighbours;
  if (needed <= 0) return true;
  const int column = at % width, row = at / width;
  int agreeing = 0;
  for (int r = max(row - 1, 0); r <= min(row + 1, height - 1); ++r) {
    for (int c = max(column - 1, 0); c <= min(column + 1, width - 1); ++c) {
      if (r == row && c == column) continue;
      if (abs(coordinate_at(r * width + c) - y) < points.half_fringe) ++agreeing;
    }
  }
  return agreeing >= needed;
}

float of_ray(float c[3], float E_x, float E_y) { return fma(c[0], E_x, fma(c[1], E_y, c[2])); }

// PlanePolynomial, its coefficients from the last to the first.
float lens_adds(float p, float q) {
  if (points.lens_degree == 0) return 0.0;
  int at = points.lens;
  float sum = word(at++);
  for (int i = points.lens_degree - 1; i >= 0; --i) {
    float inner = word(at++);
    for (int j = points.lens_degree - i - 1; j >= 0; --j) inner = fma(inner, q, word(at++));
    sum = fma(sum, p, inner);
  }
  return sum;
}

float edge(float c[6], float p) {
  float sum = c[5];
  for (int i = 4; i >= 0; --i) sum = fma(sum, p, c[i]);
  return sum;
}

// Depth of the pixel's point, and why there is none: StripeGeometry::operator().
uint point(int at, float y, out float z) {
  const int four = at / 4 * 8 + at % 4;
  float E_x = rays[four], E_y = rays[four + 4];
  float p = fma(y, points.unit_scale, points.unit_offset);
  float g = of_ray(points.facing, E_x, E_y);
  float q = fma(p, of_ray(points.place_slope, E_x, E_y), of_ray(points.place_constant, E_x, E_y)) / g;
  float w = y + lens_adds(p, q);
  float numerator = fma(w, points.depth_offset, -points.coordinate_offset);
  float denominator =
      fma(-w, of_ray(points.depth, E_x, E_y), of_ray(points.coordinate, E_x, E_y));
  z = numerator / denominator;
  if (!(z > 0.0 && z <= 3.4e38 && denominator * g > 0.0) || y >= no_coordinate) return no_point;
  bool lit = q > points.inner_low && q < points.inner_high ||
             q >= edge(points.low_edge, p) && q <= edge(points.high_edge, p);
  bool left = points.may_leave_field != 0 &&
              !(y >= points.least_coordinate && y <= points.largest_coordinate);
  if (!lit || left) return outside_field;
  return z >= points.nearest && z <= points.farthest ? valid : out_of_range;
}

// The first reason in the order of Validity.
uint reason(int at, out float z) {
  const int flags = flags_at(at);
  const float y = coordinate_at(at);
  z = 0.0;
  if ((flags & dark) != 0) return too_dark;
  if ((flags & saturated) != 0) return is_saturated;
  if (!is_confirmed(at, y, flags)) return doubtful;
  return point(at, y, z);
}

void main() {
  const int first = first_pixel(), fours = first / 4;
  if (first >= pixel_count()) return;
  uvec4 x, y, z;
  uint packed = 0u;
  for (int k = 0; k < 4 && first + k < pixel_count(); ++k) {
    float depth;
    uint why = reason(first + k, depth);
    packed |= why << 8 * k;
    x[k] = why == valid ? written(rays[8 * fours + k] * depth) : nan;
    y[k] = why == valid ? written(rays[8 * fours + 4 + k] * depth) : nan;
    z[k] = why == valid ? written(depth) : nan;
  }
  if (x_plane >= 0) {
    planes[x_plane + fours] = x;
    planes[y_plane + fours] = y;
  }
  planes[z_plane + fours] = z;
  reasons[fours] = packed;
}
