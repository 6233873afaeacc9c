#version 450
#extension GL_GOOGLE_include_directive : require
// Frames to the projector coordinate of every pixel, as the row kernels compute it: sums of the
// frames, wrapped phases, fringe orders along the chain.
layout(local_size_x = 64) in;
layout(constant_id = 0) const int pixel_bits = 8;
layout(constant_id = 1) const int band_count = 1;

#include "stages.glsl"

// Frame after frame, then the coarse coordinates where they are given.
layout(std430, binding = 0) readonly buffer Frames { uint frame_bits[]; };
layout(std430, binding = 3) writeonly buffer Between { uvec4 between[]; };
layout(std430, binding = 4) writeonly buffer Output { uvec4 planes[]; };

// Of the pixel at work, of each band: wrapped phase / (2 pi).
float turns[band_count];

struct Pixel {
  float mean, modulation, y, doubt;
  int flags;
};

int level(int frame, int pixel) {
  const int in_word = 32 / pixel_bits;
  uint bits = frame_bits[frame * frame_words + pixel / in_word];
  return int(bitfieldExtract(bits, pixel % in_word * pixel_bits, pixel_bits));
}

// atan2(S, C) / (2 pi) in [0, 1] to 4e-7 rad: the polynomial of sinusoid_turns-inl.h.
float angle_in_turns(float S, float C) {
  float sine = abs(S), cosine = abs(C);
  float smaller = min(sine, cosine), greater = max(max(sine, cosine), 1e-30);
  const float tangent = 0.41421356237;
  float q = fma(-tangent, greater, smaller) / fma(tangent, smaller, greater);
  float q2 = q * q;
  float slope = fma(q2, -0.01715644503710709, 0.03116408851608355);
  slope = fma(q2, slope, -0.05302114738541977);
  slope = fma(q2, slope, 0.15915456249778778);
  float eighth = max(fma(q, slope, 0.0625), 0.0);
  float quarter = sine > cosine ? 0.25 - eighth : eighth;
  float half_turn = C < 0.0 ? 0.5 - quarter : quarter;
  return S < 0.0 ? 1.0 - half_turn : half_turn;
}

float corrected(Band band, float turn) {
  if (band.wave_terms > 0) {
    float r = fma(turn, float(band.steps), -roundEven(turn * float(band.steps)));
    float slope = word(band.wave);
    for (int i = 1; i < band.wave_terms; ++i) slope = fma(slope, r * r, word(band.wave + i));
    turn = fma(slope, r, turn);
    return turn - floor(turn);
  }
  if (band.segments == 0) return turn;
  float place = turn * float(band.segments);
  int segment = int(place);
  float added = word(band.table + segment), next = word(band.table + segment + 1);
  turn += fma(place - float(segment), next - added, added);
  return turn - floor(turn);
}

// A sum of whole parts of the weights, exact until it is rounded once.
float joined(int most, int middle, int least, float unit) {
  return (float(most) * 4194304.0 + (float(middle) * 2048.0 + float(least))) * unit;
}

void decode(const int index, const int at, inout Pixel pixel) {
  const Band band = bands[index];
  int c0 = 0, c1 = 0, c2 = 0, s0 = 0, s1 = 0, s2 = 0, greatest = 0;
  float sum = 0.0;
  for (int n = 0; n < band.frames; ++n) {
    int I = level(band.first_frame + n, at), w = band.weights + 7 * n;
    c0 += words[w] * I;
    c1 += words[w + 1] * I;
    c2 += words[w + 2] * I;
    s0 += words[w + 3] * I;
    s1 += words[w + 4] * I;
    s2 += words[w + 5] * I;
    sum = fma(word(w + 6), float(I), sum);
    greatest = max(greatest, I);
  }
  float U = joined(c0, c1, c2, band.cosine_unit), V = joined(s0, s1, s2, band.sine_unit);
  float square = fma(band.sine_square * V, V, U * U);
  if (square < band.least_square) pixel.flags |= dark;
  if (greatest >= band.full_scale) pixel.flags |= saturated;
  float modulation = sqrt(square) * band.modulation_scale;
  pixel.modulation = index == 0 ? modulation : min(modulation, pixel.modulation);
  if (index == 0) pixel.mean = sum * band.mean_scale;
  float turn = corrected(band, angle_in_turns(band.sine_weight * V, U));
  if (band.direction != 1.0 || band.offset != 0.0) {
    turn = fma(band.direction, turn, band.offset);
    turn -= floor(turn);
  }
  turns[index] = turn;
}

float sum_of_bands(Link link) {
  if (link.alone >= 0) return turns[link.alone];
  float sum = 0.0;
  for (int i = 0; i < band_count; ++i) {
    sum = fma(float(words[link.factors + i]), turns[i], sum);
  }
  return sum - floor(sum);
}

// The middle of the stripe that the bits show.
float code_coordinate(int at, float mean) {
  precise float limit = mean * code.mean_to_frames;
  if (code.against_mean == 0 && code.inverses < 0) {
    limit = 0.0;
    for (int n = 0; n < words[code.reference]; ++n) {
      precise float part = word(code.reference + 1 + n) * float(level(n, at));
      limit += part;
    }
  }
  int shown = 0;
  for (int bit = 0; bit < code.bits; ++bit) {
    int against = code.inverses < 0 ? int(limit) : level(words[code.inverses + bit], at);
    shown = 2 * shown + (level(words[code.frames + bit], at) > against ? 1 : 0);
  }
  if ((shown & code.base) != 0) shown ^= code.others;
  if (code.gray != 0) {
    for (int shift = 1; shift < 32; shift *= 2) shown ^= shown >> shift;
  }
  return fma(float(shown), code.stripe, 0.5 * code.stripe);
}

float begin_of_chain(int at, Pixel pixel) {
  if (coarse_given != 0) return uintBitsToFloat(frame_bits[coarse_given + at]);
  if (begins_with_code != 0) return code_coordinate(at, pixel.mean);
  float sum = sum_of_bands(coarse);
  return coarse_in_field != 0 ? in_field(coarse_stage, sum) : sum;
}

// Fringe orders from band to band, Eq. (1.17).
void unwrap(int at, inout Pixel pixel) {
  float y = begin_of_chain(at, pixel);
  const bool known = y < no_coordinate;
  for (int i = 0; i < links; ++i) {
    const Link link = chain[i];
    float high = sum_of_bands(link);
    float periods = fma(y, link.ratio, -high), k = roundEven(periods);
    float apart = max(abs(periods - k) - link.open, 0.0) * link.doubt_scale;
    pixel.doubt = i == 0 ? apart : max(apart, pixel.doubt);
    if (apart > link.largest_doubt) pixel.flags |= doubtful_order;
    y = in_field(link.coordinate, high + k);
  }
  pixel.y = known ? y : no_coordinate;
}

// The coordinates of all bands weighed, at the orders next to that of the chain.
void weigh(inout Pixel pixel) {
  float sum = pixel.y;
  for (int i = 1; i < band_count; ++i) {
    if (bands[i].weight == 0.0) continue;
    float k = roundEven(fma(pixel.y, bands[i].periods, -turns[i]));
    sum = fma(bands[i].weight, (turns[i] + k) * (1.0 / bands[i].periods) - pixel.y, sum);
  }
  Coordinate stage = Coordinate(1.0, coordinate.period, coordinate.cut);
  pixel.y = coarse_in_field != 0 ? sum : in_field(stage, sum);
}

float wrapped_phase(float turn) {
  float part = turn - floor(turn);
  return part < 1.0 ? min(part * 6.2831853, 6.2831850) : 0.0;
}

Pixel measured(int at) {
  Pixel pixel;
  pixel.flags = 0;
  pixel.doubt = 0.0;
  for (int i = 0; i < band_count; ++i) decode(i, at, pixel);
  if (links == 0) {
    pixel.y = in_field(coordinate, turns[0]);
    return pixel;
  }
  unwrap(at, pixel);
  if (weighs_bands != 0) weigh(pixel);
  return pixel;
}

void write(int plane, int fours, uvec4 values) {
  if (plane >= 0) planes[plane + fours] = values;
}

void main() {
  const int first = first_pixel(), fours = first / 4;
  if (first >= pixel_count()) return;
  uvec4 mean, modulation, phase, y, seen, doubt, flags;
  for (int k = 0; k < 4; ++k) {
    Pixel pixel = measured(first + k);
    mean[k] = written(pixel.mean);
    modulation[k] = written(pixel.modulation);
    phase[k] = written(wrapped_phase(turns[0]));
    y[k] = pixel.y < no_coordinate ? written(pixel.y) : nan;
    seen[k] = written((pixel.flags & dark) != 0 ? no_coordinate : pixel.y);
    doubt[k] = written(pixel.doubt);
    flags[k] = uint(pixel.flags);
  }
  write(mean_plane, fours, mean);
  write(modulation_plane, fours, modulation);
  write(phase_plane, fours, phase);
  write(coordinate_plane, fours, y);
  write(doubt_plane, fours, doubt);
  if (z_plane < 0) return;
  between[2 * fours] = seen;
  between[2 * fours + 1] = flags;
}
