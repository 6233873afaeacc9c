#version 450
#extension GL_GOOGLE_include_directive : require
// Coordinates of four pixels to points, confirmed by their neighbours: StripeGeometry and
// FringeOrderConsensus, computed as by the row kernels.
layout(local_size_x = 64) in;

#include "stages.glsl"

layout(std430, binding = 2) readonly buffer Rays { vec4 rays[]; };  // E_x and E_y alternate
layout(std430, binding = 3) readonly buffer Between { uint between[]; };
layout(std430, binding = 4) writeonly buffer Output { uvec4 planes[]; };
layout(std430, binding = 5) writeonly buffer Packed { uint packed[]; };

// Values of Validity; the first reason in this order wins.
const int valid = 0, too_dark = 1, is_saturated = 2, doubtful = 3, no_point = 4, outside_field = 5,
          out_of_range = 6;

float coordinate_at(int at) { return uintBitsToFloat(between[place(0, at)]); }

int agreeing(float y, int row, int column) {
  if (row < 0 || row >= height || column < 0 || column >= width) return 0;
  const float apart = abs(coordinate_at(row * width + column) - y);
  return y < no_coordinate && apart < consensus.half_fringe ? 1 : 0;
}

bool is_confirmed(int at, float y, int flags) {
  const int needed =
      (flags & doubtful_order) != 0 ? consensus.fewest_if_doubtful : consensus.fewest_neighbours;
  const int column = at % width, row = at / width;

  // On a surface, the neighbours in the row are enough.
  int found = agreeing(y, row, column - 1) + agreeing(y, row, column + 1);
  if (found >= needed) return true;

  for (int side = -1; side <= 1; side += 2) {
    for (int c = column - 1; c <= column + 1; ++c) found += agreeing(y, row + side, c);
  }

  return found >= needed;
}

vec4 of_rays(float c[3], vec4 E_x, vec4 E_y) {
  return fma(vec4(c[0]), E_x, fma(vec4(c[1]), E_y, vec4(c[2])));
}

// PlanePolynomial, coefficients from the last to the first.
vec4 lens_adds(vec4 p, vec4 q) {
  if (points.lens_degree == 0) return vec4(0.0);

  int at = lens;
  vec4 sum = vec4(word(at++));

  for (int i = points.lens_degree - 1; i >= 0; --i) {
    vec4 inner = vec4(word(at++));
    for (int j = points.lens_degree - i - 1; j >= 0; --j) inner = fma(inner, q, vec4(word(at++)));
    sum = fma(sum, p, inner);
  }

  return sum;
}

vec4 edge(float c[6], vec4 p) {
  vec4 sum = vec4(c[5]);
  for (int i = 4; i >= 0; --i) sum = fma(sum, p, vec4(c[i]));
  return sum;
}

// Depth and validity of the pixels' points: StripeGeometry::operator().
ivec4 find_points(vec4 E_x, vec4 E_y, vec4 y, out vec4 z) {
  // 1. The position q along the stripe where the ray's epipolar line crosses y.
  vec4 p = fma(y, vec4(points.unit_scale), vec4(points.unit_offset));
  vec4 g = of_rays(points.facing, E_x, E_y);
  vec4 q =
      fma(p, of_rays(points.place_slope, E_x, E_y), of_rays(points.place_constant, E_x, E_y)) / g;

  // 2. The undistorted coordinate w, and the depth at which its plane meets the ray.
  vec4 w = y + lens_adds(p, q);
  vec4 numerator = fma(w, vec4(points.depth_offset), vec4(-points.coordinate_offset));
  vec4 denominator = fma(-w, of_rays(points.depth, E_x, E_y), of_rays(points.coordinate, E_x, E_y));
  z = numerator / denominator;

  // 3. The conditions that a point must meet.
  vec4 low = edge(points.low_edge, p), high = edge(points.high_edge, p);
  ivec4 why;
  for (int k = 0; k < 4; ++k) {
    bool exists =
        abs(denominator[k]) > 1e-30 && z[k] > 0.0 && denominator[k] * g[k] > 0.0;
    bool lit = q[k] > points.inner_low && q[k] < points.inner_high ||
               q[k] >= low[k] && q[k] <= high[k];
    bool in_field = points.may_leave_field == 0 ||
                    y[k] >= points.least_coordinate && y[k] <= points.largest_coordinate;

    why[k] = !exists || y[k] >= no_coordinate                       ? no_point
             : !lit || !in_field                                    ? outside_field
             : z[k] >= points.nearest && z[k] <= points.farthest    ? valid
                                                                    : out_of_range;
  }

  return why;
}

// DepthScale::operator().
void write_numbers(int at, vec4 z, ivec4 why) {
  uvec4 numbers = uvec4(0u);

  for (int k = 0; k < 4; ++k) {
    float number = (z[k] - packing.offset) * packing.numbers_per_mm + 0.5;
    if (why[k] == valid && number >= 1.0 && number < 65536.0) numbers[k] = uint(number);
  }

  packed[2 * at] = numbers.x | numbers.y << 16;
  packed[2 * at + 1] = numbers.z | numbers.w << 16;
}

void main() {
  const int first = first_pixel(), fours = first / 4, among_scans = scan() * plane_fours + fours;
  if (first >= pixel_count()) return;

  // 1. The pixels' coordinates and flags.
  vec4 y, z;
  ivec4 flags;
  for (int k = 0; k < 4; ++k) {
    y[k] = coordinate_at(first + k);
    flags[k] = int(between[place(1, first + k)]);
  }

  // 2. Their points, and why some have none: the first reason wins.
  const vec4 E_x = rays[2 * fours], E_y = rays[2 * fours + 1];
  ivec4 why = find_points(E_x, E_y, y, z);
  for (int k = 0; k < 4; ++k) {
    if ((flags[k] & dark) != 0) why[k] = too_dark;
    else if ((flags[k] & saturated) != 0) why[k] = is_saturated;
    else if (confirmed != 0 && !is_confirmed(first + k, y[k], flags[k])) why[k] = doubtful;
  }

  // 3. Write 16-bit depth, or the points and their validity.
  if (packing.numbers_per_mm > 0.0) {
    write_numbers(among_scans, z, why);
    return;
  }

  const bvec4 good = equal(why, ivec4(valid));
  const int at = scan() * scan_fours + fours;
  if (plane_at.x >= 0) {
    planes[plane_at.x + at] = mix(uvec4(nan), floatBitsToUint(E_x * z), good);
    planes[plane_at.y + at] = mix(uvec4(nan), floatBitsToUint(E_y * z), good);
  }

  planes[plane_at.z + at] = mix(uvec4(nan), floatBitsToUint(z), good);
  packed[among_scans] = uint(why.x | why.y << 8 | why.z << 16 | why.w << 24);
}
