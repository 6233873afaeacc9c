// Shared by the shaders: the stages of a scan, and access to places and numbers.
#include "gpu_stages.h"

float word(int at) { return intBitsToFloat(words[at]); }

const int dark = 1, saturated = 2, doubtful_order = 4, dim = 8, no_vote = 16;

// Replaces NaN, which drivers need not support: a coordinate far from all others.
const float no_coordinate = 1e30;
const uint nan = 0x7fc00000u;

int pixel_count() { return width * height; }

// Index among the scans computed at once.
int scan() { return int(gl_WorkGroupID.z); }

// Words kept of four pixels between the shaders, by slot: y, flags, and with a cue modulation, the
// cue and its sine, the periods from the cue, and two shifts.
int place(int slot, int at) { return 4 * ((scan() * plane_fours + at / 4) * kept + slot) + at % 4; }

// sin(2 pi turns) to 2e-7, for up to a quarter turn. A driver's own sin and cos may be wrong by
// 2^-11, and by any amount beyond half a turn.
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
  return cost.form == linear ? 2.0 * held - 1.0 : cosine_of(0.5 * held);
}

// The first of this invocation's four pixels.
int first_pixel() {
  return 4 * int((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x +
                 gl_LocalInvocationID.x);
}

// coordinate_in_field, from turns.
vec4 in_field(CoordinateStage stage, vec4 turns) {
  vec4 fields = floor(fma(turns, vec4(stage.fields_of_turn), vec4(-stage.cut_fields)));
  return fma(vec4(-stage.period), fields, turns * stage.scale);
}
