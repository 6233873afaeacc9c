#version 450
#extension GL_GOOGLE_include_directive : require
// Frames to the projector coordinates of four pixels, computed as by the row kernels: sums of the
// frames, wrapped phases, fringe orders along the chain.
layout(local_size_x = 64) in;
layout(constant_id = 0) const int pixel_bits = 8;
layout(constant_id = 1) const int band_count = 1;

#include "stages.glsl"

// Frame after frame, then the coarse coordinates, if given.
layout(std430, binding = 0) readonly buffer Frames { uint frame_bits[]; };
layout(std430, binding = 3) writeonly buffer Between { uvec4 between[]; };
layout(std430, binding = 4) writeonly buffer Output { uvec4 planes[]; };

// Wrapped phase / (2 pi) of this invocation's pixels, for each band.
vec4 turns[band_count];

struct Pixels {
  vec4 mean, square, modulation, y, doubt;
  ivec4 flags;
};

ivec4 levels(int frame, int fours) {
  const int first_word = scan() * scan_words + frame * plane_fours * (pixel_bits / 8);
  if (pixel_bits == 8) {
    uint bits = frame_bits[first_word + fours];
    return ivec4(bits & 255u, bits >> 8 & 255u, bits >> 16 & 255u, bits >> 24);
  }

  uint first = frame_bits[first_word + 2 * fours], second = frame_bits[first_word + 2 * fours + 1];
  return ivec4(first & 65535u, first >> 16, second & 65535u, second >> 16);
}

ivec4 flagged(int flag, bvec4 which) { return flag * ivec4(which); }

// To half a unit in the last place: a driver's own division may be five times worse.
vec4 quotients(vec4 a, vec4 b) {
  const vec4 q = a / b;
  precise const vec4 rest = fma(-q, b, a);
  return q + rest / b;
}

// atan2(S, C) / (2 pi) in [0, 1] to 4e-7 rad, as in sinusoid_sums-inl.h.
vec4 angles_in_turns(vec4 S, vec4 C) {
  vec4 sine = abs(S), cosine = abs(C);
  vec4 smaller = min(sine, cosine), greater = max(max(sine, cosine), vec4(1e-30));

  // The angle of the smaller to the greater, measured from pi/8, as a polynomial in q.
  const vec4 tangent = vec4(0.41421356237);
  vec4 numerator = fma(-tangent, greater, smaller), denominator = fma(tangent, smaller, greater);
  vec4 q = quotients(numerator, denominator);
  vec4 q2 = q * q;

  vec4 slope = fma(q2, vec4(-0.01715644503710709), vec4(0.03116408851608355));
  slope = fma(q2, slope, vec4(-0.05302114738541977));
  slope = fma(q2, slope, vec4(0.15915456249778778));

  // From the first eighth of the circle to all of it.
  vec4 eighth = max(fma(q, slope, vec4(0.0625)), vec4(0.0));
  vec4 quarter = mix(eighth, 0.25 - eighth, greaterThan(sine, cosine));
  vec4 half_turn = mix(quarter, 0.5 - quarter, lessThan(C, vec4(0.0)));
  return mix(half_turn, 1.0 - half_turn, lessThan(S, vec4(0.0)));
}

vec4 corrected(int index, vec4 turn) {
  const int wave_terms = bands[index].wave_terms, segments = bands[index].segments;

  // A polynomial in r, the distance of N times the turn from the nearest whole number.
  if (wave_terms > 0) {
    const int wave = bands[index].wave;
    vec4 N = vec4(bands[index].sinusoid.steps);
    vec4 r = fma(turn, N, -roundEven(turn * N));

    vec4 slope = vec4(word(wave));
    for (int i = 1; i < wave_terms; ++i) slope = fma(slope, r * r, vec4(word(wave + i)));

    turn = fma(slope, r, turn);
    return turn - floor(turn);
  }

  // Or a table around the circle, linear between its entries.
  if (segments == 0) return turn;

  const int table = bands[index].table;
  vec4 place = turn * float(segments);
  ivec4 segment = ivec4(place);
  vec4 added, next;
  for (int k = 0; k < 4; ++k) {
    added[k] = word(table + segment[k]);
    next[k] = word(table + segment[k] + 1);
  }

  turn += fma(place - vec4(segment), next - added, added);
  return turn - floor(turn);
}

// Joins the sums over the parts of the weights; exact until they are rounded once.
vec4 joined(ivec4 most, ivec4 middle, ivec4 least, float unit) {
  return (vec4(most) * 4194304.0 + (vec4(middle) * 2048.0 + vec4(least))) * unit;
}

struct Sums {
  vec4 U, V, mean;
  ivec4 greatest;
};

Sums sums(const int index, const int fours) {
  ivec4 c0 = ivec4(0), c1 = c0, c2 = c0, s0 = c0, s1 = c0, s2 = c0, greatest = c0;
  vec4 sum = vec4(0.0);

  const int count = bands[index].frames, first = bands[index].first_frame;
  for (int n = 0; n < count; ++n) {
    const int w = bands[index].weights + 7 * n;
    ivec4 I = levels(first + n, fours);

    // Whole weights fit into the lowest part.
    if (bands[index].whole == 0) {
      c0 += words[w] * I;
      c1 += words[w + 1] * I;
      s0 += words[w + 3] * I;
      s1 += words[w + 4] * I;
    }

    c2 += words[w + 2] * I;
    s2 += words[w + 5] * I;
    sum = fma(vec4(word(w + 6)), vec4(I), sum);
    greatest = max(greatest, I);
  }

  return Sums(joined(c0, c1, c2, bands[index].cosine_unit),
              joined(s0, s1, s2, bands[index].sine_unit), sum, greatest);
}

void decode(const int index, const int fours, inout Pixels pixels) {
  // 1. Sums, and the flags that follow from them.
  const Sums of = sums(index, fours);
  const vec4 U = of.U, V = of.V;
  vec4 square = fma(bands[index].sinusoid.sine_square * V, V, U * U);

  pixels.flags |= flagged(dark, lessThan(square, vec4(bands[index].limits.least_square)));
  pixels.flags |=
      flagged(saturated, greaterThanEqual(of.greatest, ivec4(bands[index].limits.full_scale)));

  // 2. Levels: the least modulation of all bands, and the mean of the first.
  vec4 modulation = sqrt(square) * bands[index].sinusoid.modulation_scale;
  pixels.modulation = index == 0 ? modulation : min(modulation, pixels.modulation);
  if (index == 0) {
    pixels.mean = of.mean * bands[index].limits.mean_scale;
    pixels.square = square;
  }

  // 3. The wrapped phase; steps may begin elsewhere or go backwards.
  vec4 turn = corrected(index, angles_in_turns(bands[index].sinusoid.sine_weight * V, U));
  const float direction = bands[index].sinusoid.direction, offset = bands[index].sinusoid.offset;
  if (direction != 1.0 || offset != 0.0) {
    turn = fma(vec4(direction), turn, vec4(offset));
    turn -= floor(turn);
  }

  turns[index] = turn;
}

vec4 sum_of_bands(int factors, int alone) {
  if (alone >= 0) return turns[alone];

  vec4 sum = vec4(0.0);
  for (int i = 0; i < band_count; ++i) sum = fma(vec4(words[factors + i]), turns[i], sum);

  return sum - floor(sum);
}

// Middles of the stripes given by the bits.
vec4 code_coordinates(int fours, vec4 mean) {
  // 1. The level above which a bit is bright: the mean, or a weighted sum of frames.
  precise vec4 limit = mean * code.mean_to_frames;
  if (code.against_mean == 0 && code.inverses < 0) {
    limit = vec4(0.0);
    for (int n = 0; n < words[code.reference]; ++n) {
      precise vec4 part = word(code.reference + 1 + n) * vec4(levels(n, fours));
      limit += part;
    }
  }

  // 2. Read the bits, the highest first.
  ivec4 shown = ivec4(0);
  for (int bit = 0; bit < code.count; ++bit) {
    ivec4 against =
        code.inverses < 0 ? ivec4(floor(limit)) : levels(words[code.inverses + bit], fours);
    bvec4 bright = greaterThan(levels(words[code.frames + bit], fours), against);
    shown = 2 * shown + ivec4(bright);
  }

  // 3. To the number of the stripe: undo the base bit's inversion, then the Gray code.
  bvec4 inverted = notEqual(shown & code.bits.base, ivec4(0));
  shown ^= flagged(code.bits.others, inverted);
  if (code.bits.gray != 0) {
    for (int shift = 1; shift < 32; shift *= 2) shown ^= shown >> shift;
  }

  return fma(vec4(shown), vec4(code.bits.stripe), vec4(0.5 * code.bits.stripe));
}

vec4 begin_of_chain(int fours, vec4 mean) {
  if (coarse_given != 0) {
    const int at = scan() * scan_words + coarse_given + 4 * fours;
    return uintBitsToFloat(
        uvec4(frame_bits[at], frame_bits[at + 1], frame_bits[at + 2], frame_bits[at + 3]));
  }

  if (begins_with_code != 0) return code_coordinates(fours, mean);

  vec4 sum = sum_of_bands(coarse.factors, coarse.alone);
  return coarse_in_field != 0 ? in_field(coarse_stage, sum) : sum;
}

// Fringe orders from band to band, Eq. (1.17).
void unwrap(int fours, inout Pixels pixels) {
  vec4 y = begin_of_chain(fours, pixels.mean);

  // Unknown coarse coordinates stay unknown.
  const bvec4 known = lessThan(y, vec4(no_coordinate));

  for (int i = 0; i < links; ++i) {
    vec4 high = sum_of_bands(chain[i].factors, chain[i].alone);
    vec4 periods = fma(y, vec4(chain[i].unwrap.ratio), -high), k = roundEven(periods);

    vec4 apart =
        max(abs(periods - k) - chain[i].unwrap.open, vec4(0.0)) * chain[i].unwrap.doubt_scale;
    pixels.doubt = max(apart, pixels.doubt);
    pixels.flags |=
        flagged(doubtful_order, greaterThan(apart, vec4(chain[i].unwrap.largest_doubt)));

    y = in_field(chain[i].unwrap.coordinate, high + k);
  }

  pixels.y = mix(vec4(no_coordinate), y, known);
}

// Weighted mean of all bands' coordinates, at the orders nearest to the chain's.
void weigh(inout Pixels pixels) {
  vec4 sum = pixels.y;

  for (int i = 1; i < band_count; ++i) {
    if (bands[i].weight == 0.0) continue;
    vec4 k = roundEven(fma(pixels.y, vec4(bands[i].periods), -turns[i]));
    vec4 other = (turns[i] + k) * bands[i].period;
    sum = fma(vec4(bands[i].weight), other - pixels.y, sum);
  }

  pixels.y = coarse_in_field != 0 ? sum : in_field(weighed, sum);
}

// CueEvidence::coordinate, in periods of the measuring band.
vec4 cue_periods(Sums channel, vec4 modulation) {
  if (cost.form == circle) return cue.periods * angles_in_turns(channel.V, channel.U);

  // R from the channel and the modulation, then its inverse.
  const vec4 light = max(modulation, vec4(1e-9));
  vec4 R = clamp(cue.gain * ((channel.U - cue_limits.ambient) / light) - cue.offset, -1.0, 1.0);
  vec4 y = cost.form == linear ? 0.5 * R + 0.5
                              : 2.0 * angles_in_turns(sqrt(max(1.0 - R * R, vec4(0.0))), R);

  return mix(vec4(0.0), cue.periods * y, greaterThan(modulation, vec4(1e-9)));
}

// From each pixel alone; the neighbours vote later.
void decode_cue(int fours, Sums channel, vec4 expected, inout Pixels pixels) {
  const bool turns_round = cost.form == circle;

  // A turn of 1 means 0, which matters unless the cue is a circle.
  vec4 turn = turns[0];
  if (!turns_round) turn = mix(vec4(0.0), turn, lessThan(turn, vec4(1.0)));

  // The order nearest to the cue.
  const vec4 periods = expected - turn;
  vec4 k = roundEven(periods);
  if (!turns_round) k = clamp(k, 0.0, cue.periods - 1.0);
  pixels.y = turns_round ? in_field(coordinate, turn + k) : (turn + k) * coordinate.scale;

  pixels.doubt = abs(periods - k);
  if (!turns_round) pixels.doubt = min(pixels.doubt, vec4(0.5));

  pixels.flags |= flagged(dim, lessThanEqual(pixels.square, vec4(cue_limits.lit_square))) |
                  flagged(no_vote, lessThan(pixels.square, vec4(cue_limits.voting_square))) |
                  flagged(doubtful_order, greaterThan(pixels.doubt, vec4(cue.largest_doubt)));

  // For the vote, in grey levels of 8 bits.
  const int at = (scan() * plane_fours + fours) * kept;
  between[at + 2] = floatBitsToUint(vote.to_8_bits * pixels.modulation);
  between[at + 3] = floatBitsToUint(vote.to_8_bits * channel.U);
  between[at + 4] = floatBitsToUint(vote.to_8_bits * channel.V);
  between[at + 5] = floatBitsToUint(expected);
  between[at + 6] = uvec4(0u);
}

Pixels measured(int fours) {
  Pixels pixels = Pixels(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), ivec4(0));

  for (int i = 0; i < band_count; ++i) decode(i, fours, pixels);

  if (cost.form != 0) {
    const Sums channel = sums(1, fours);
    decode_cue(fours, channel, cue_periods(channel, pixels.modulation), pixels);
    return pixels;
  }

  if (links == 0) {
    pixels.y = in_field(coordinate, turns[0]);
    return pixels;
  }

  unwrap(fours, pixels);
  if (weighs_bands != 0) weigh(pixels);
  return pixels;
}

vec4 wrapped_phases(vec4 turn) {
  vec4 part = turn - floor(turn);
  return mix(vec4(0.0), min(part * 6.2831853, vec4(6.2831850)), lessThan(part, vec4(1.0)));
}

void write(int plane, int fours, uvec4 values) {
  if (plane >= 0) planes[scan() * scan_fours + plane + fours] = values;
}

void main() {
  const int fours = first_pixel() / 4;
  if (4 * fours >= pixel_count()) return;

  const Pixels pixels = measured(fours);
  const bvec4 known = lessThan(pixels.y, vec4(no_coordinate));

  // Maps.
  write(plane_at.mean, fours, floatBitsToUint(pixels.mean));
  write(plane_at.modulation, fours, floatBitsToUint(pixels.modulation));
  write(plane_at.phase, fours, floatBitsToUint(wrapped_phases(turns[0])));
  write(plane_at.coordinate, fours, mix(uvec4(nan), floatBitsToUint(pixels.y), known));
  write(plane_at.doubt, fours, floatBitsToUint(pixels.doubt));

  // Coordinates for the vote and the points. Dark pixels confirm no neighbour; with a cue, the flag
  // no_vote decides that.
  if (packing.wanted == 0 && cost.form == 0) return;
  const bvec4 lit = equal(pixels.flags & (cost.form == 0 ? dark : 0), ivec4(0));
  const int at = (scan() * plane_fours + fours) * kept;
  between[at] = floatBitsToUint(mix(vec4(no_coordinate), pixels.y, lit));
  between[at + 1] = uvec4(pixels.flags);
}
