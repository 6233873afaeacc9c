// What the stages of a scan are: GpuStages of gpu_stages.h, word for word.
const int most_bands = 16;

struct Coordinate {
  float scale, period, fields_of_turn, cut_fields;
};

struct Band {
  int first_frame, frames, weights, whole;
  float cosine_unit, sine_unit;
  float sine_weight, sine_square, modulation_scale;
  float least_square, mean_scale;
  int full_scale;
  int steps, wave_terms, wave, segments, table;
  float direction, offset;
  float periods, period, weight;
};

struct Link {
  int factors, alone;
  float ratio, largest_doubt, open, doubt_scale;
  Coordinate coordinate;
};

struct Code {
  int bits, frames, inverses, gray, base, others, against_mean, reference;
  float stripe, mean_to_frames;
};

struct Points {
  float coordinate[3], depth[3], facing[3], place_constant[3], place_slope[3];
  float coordinate_offset, depth_offset, unit_scale, unit_offset;
  float least_coordinate, largest_coordinate;
  int may_leave_field, lens_degree, lens;
  float low_edge[6], high_edge[6];
  float inner_low, inner_high, nearest, farthest;
  float half_fringe;
  int confirmed, fewest_neighbours, fewest_if_doubtful;
};

struct Cue {
  int form;  // 0: none
  float periods, period, gain, offset, shade, largest_doubt;
  float share, cue_share, relative_share, constant_light, steady;
  float cue_variance, relative_variance, circle_weight, margin;
  int lines;
  float ambient, lit_square, voting_square, to_8_bits;
};

layout(std430, binding = 1) readonly buffer Stages {
  int width, height;
  int plane_fours;  // of a frame, a plane
  int scan_words, scan_fours;  // of a scan's frames and coarse coordinates, of its planes
  int links;
  int kept;  // slots between the shaders
  int begins_with_code, coarse_given, coarse_in_field, weighs_bands;
  Coordinate coarse_stage;
  Coordinate coordinate, weighed;
  Link coarse;
  Code code;
  Points points;
  Cue cue;
  // Where planes of the output begin, in fours of pixels; -1 where one is not wanted.
  int x_plane, y_plane, z_plane, mean_plane, modulation_plane, phase_plane, coordinate_plane,
      doubt_plane;
  int wants_points;
  float numbers_per_mm, depth_offset;  // 0: reasons are wanted
  Band bands[most_bands];
  Link chain[most_bands];
  int words[];
};

float word(int at) { return intBitsToFloat(words[at]); }

const int dark = 1, saturated = 2, doubtful_order = 4, dim = 8, nobody = 16;
const int linear = 1, cosine = 2, circle = 3;

// Instead of NaN, which a driver need not keep: a coordinate that nothing is near to.
const float no_coordinate = 1e30;
const uint nan = 0x7fc00000u;

int pixel_count() { return width * height; }

// Of those that are computed at once.
int scan() { return int(gl_WorkGroupID.z); }

// What is kept of four pixels between the shaders: y, flags, and with a cue modulation, the cue and
// its sine, the periods that it gives, and shifts twice. In words:
int place(int slot, int at) { return 4 * ((scan() * plane_fours + at / 4) * kept + slot) + at % 4; }

// sin(2 pi turns) to 2e-7, of at most a quarter turn. What a driver calls sin and cos may be wrong by
// 2^-11, and by anything past half a turn.
float sine_of_quarter(float turns) {
  const float square = turns * turns;
  float slope = fma(square, 39.53670607844828, -76.54978229534504);
  slope = fma(square, slope, 81.60100407334106);
  slope = fma(square, slope, -41.34165503141761);
  return turns * fma(square, slope, 6.2831851600894835);
}

float cosine_of(float turns) { return sine_of_quarter(0.25 - abs(turns - roundEven(turns))); }

float sine_of(float turns) {
  const float rest = turns - roundEven(turns);
  return sine_of_quarter(abs(rest) > 0.25 ? 0.5 * sign(rest) - rest : rest);
}

// CueReference.
float reference(float y) {
  const float held = clamp(y, 0.0, 1.0);
  return cue.form == linear ? 2.0 * held - 1.0 : cosine_of(0.5 * held);
}

// The first of the four pixels of this invocation.
int first_pixel() {
  return 4 * int((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x +
                 gl_LocalInvocationID.x);
}

// coordinate_in_field of turns.
vec4 in_field(Coordinate stage, vec4 turns) {
  vec4 fields = floor(fma(turns, vec4(stage.fields_of_turn), vec4(-stage.cut_fields)));
  return fma(vec4(-stage.period), fields, turns * stage.scale);
}
