#version 450
#extension GL_GOOGLE_include_directive : require
// NeighbourhoodVote, one pass over all pixels at a time, and at last its results. Some drivers
// compile a function again for each call: long code is called in one place.
layout(local_size_x = 64) in;
layout(constant_id = 0) const int task = 0;

#include "stages.glsl"

layout(std430, binding = 3) buffer Between { uint between[]; };
layout(std430, binding = 4) buffer Output { float planes[]; };

// A pass reads all pixels' earlier choices from `chosen` and writes its own to `next`.
const int choose = 0, restore = 1, settle = 2;
const int chosen = 6, next = 7;  // slots
const int side = 5, cells = 25, middle = 12, line_count = 20;
const uint whole_window = 0x1ffffffu, inner_window = 0x739c0u;
const float steepest = 0.25, roughest = 0.05, most_evidence = 4.0, disagreement = 0.25, sure = 25.0,
            enough_along_a_line = 16.0, infinite = 1e30;

// The current pixel and its window.
ivec2 here;  // column, row
float window[81];
uint right, down, surface;
int link_step[2 * cells];  // to the right of each cell, then down
int shift[cells], shift_step[cells];
int candidates, candidate[cells];
uint voters[cells];

float kept_at(int slot, int at) { return uintBitsToFloat(between[place(slot, at)]); }

bool is_outside(ivec2 at) {
  return at.x < 0 || at.x >= width || at.y < 0 || at.y >= height;
}

int shift_at(ivec2 at) {
  return is_outside(at) ? 0 : int(between[place(chosen, at.y * width + at.x)]);
}

// Coordinate in periods, relative to `own`.
float periods_at(ivec2 at, float own) {
  if (is_outside(at)) return no_coordinate;

  const int pixel = at.y * width + at.x;
  if ((between[place(1, pixel)] & uint(dim | no_vote)) != 0u) return no_coordinate;
  return cue.periods * (kept_at(0, pixel) - own);
}

// A step through the window, without whole periods.
float part(int i, int further, out float whole) {
  const float a = window[i], b = window[i + further];
  whole = 0.0;
  if (max(a, b) >= no_coordinate) return no_coordinate;
  whole = roundEven(b - a);
  return b - a - whole;
}

bool linked(int i, int further, out int shift_step) {
  // This step, and those before and after it on the same line.
  float before, step, after, whole;
  for (int k = -1; k <= 1; ++k) {
    float wholes;
    const float at = part(i + k * further, further, wholes);
    if (k < 0) before = at;
    if (k == 0) step = at, whole = wholes;
    if (k > 0) after = at;
  }

  shift_step = -int(whole);

  const bool alone = before >= no_coordinate && after >= no_coordinate;
  return abs(step) <= steepest &&
         (alone || abs(step - before) <= roughest || abs(step - after) <= roughest);
}

void look_around(float y) {
  for (int i = 0; i < 81; ++i) window[i] = periods_at(here + ivec2(i % 9, i / 9) - 4, y);

  right = down = 0u;
  for (int link = 0; link < 2 * cells; ++link) {
    // One loop over both directions, so that `linked` is called in one place.
    const bool is_right = link < cells;
    const int cell = is_right ? link : link - cells;
    const ivec2 off = ivec2(cell % side, cell / side);

    if (is_right) shift[cell] = shift_at(here + off - 2);
    if ((is_right ? off.x : off.y) + 1 == side) continue;
    if (!linked(9 * (off.y + 2) + off.x + 2, is_right ? 1 : 9, link_step[link])) continue;
    if (is_right) right |= 1u << cell;
    else down |= 1u << cell;
  }
}

void find_surface(uint among) {
  shift_step[middle] = 0;
  surface = 1u << middle;

  for (uint front = surface; front != 0u;) {
    uint reached = 0u;
    for (int way = 0; way < 4; ++way) {
      // Right, left, down and up. A link has the number of its left or upper cell.
      const int step = way < 2 ? 1 : side, first_link = way < 2 ? 0 : cells;
      const bool onward = way % 2 == 0;
      const uint links = way < 2 ? right : down;
      uint to = onward ? (front & links) << step : (front & links << step) >> step;
      to &= among & ~surface & ~reached;

      reached |= to;
      for (; to != 0u; to &= to - 1u) {
        const int cell = findLSB(to), parent = onward ? cell - step : cell + step;
        const int by = link_step[first_link + min(cell, parent)];
        shift_step[cell] = shift_step[parent] + (onward ? by : -by);
      }
    }

    surface |= reached;
    front = reached;
  }
}

float slope(float y) { return vote.relative_share * reference(y) + cost.steady; }

// OrderCosts, for any shift.
float against(int cell, int by) {
  if (by == 0) return 0.0;
  const ivec2 at = here + ivec2(cell % side, cell / side) - 2;
  const int pixel = at.y * width + at.x;
  const float y = kept_at(0, pixel), other = y + float(by) * vote.period;
  if (other < -cost.margin || other > 1.0 + cost.margin) return infinite;

  const float B = kept_at(2, pixel), C = kept_at(3, pixel), S = kept_at(4, pixel);

  // On the circle: the loss of the projection c1 B + c2 along, see CircleCost.
  if (cost.form == circle) {
    const float turns = float(by) * vote.period, turn = turns - roundEven(turns);
    if (abs(turn) < 1e-5) return 1e-3;  // the cue is the same: prefer the own order

    const float cosine = cosine_of(y), sine = sine_of(y), half_sine = sine_of(0.5 * turn);
    const float along = C * cosine + S * sine, across = S * cosine - C * sine;

    const float versine = 2.0 * half_sine * half_sine;
    const float lost = cost.cue_share * (versine * along - sine_of(turn) * across);

    const float own = cost.share * B + cost.cue_share * along, held = max(own - lost, 0.0);
    const float less = own > 0.0 && held > 0.0 ? lost : max(own, 0.0) - held;
    return less * (max(own, 0.0) + held) * vote.circle_weight;
  }

  // A cue in one channel: its misfit and spread, see ReferenceCost. x: the other order, y: the own.
  const vec2 slopes = vec2(slope(other), slope(y));
  const vec2 difference = C - cost.constant_light - slopes * B;
  const vec2 spread = 1.0 + vote.relative_variance * slopes * slopes;
  const vec2 square = difference * difference / (cost.cue_variance * spread);
  return square.x - square.y + log(spread.x / spread.y);
}

// Shifts of the middle pixel implied by its surface, most frequent first.
void name_candidates() {
  candidates = 0;

  for (uint rest = surface; rest != 0u;) {
    const int first = findLSB(rest), implied = shift[first] - shift_step[first];

    uint same = 0u;
    for (uint left = rest; left != 0u; left &= left - 1u) {
      const int cell = findLSB(left);
      if (shift[cell] - shift_step[cell] == implied) same |= 1u << cell;
    }

    rest &= ~same;

    // Insert it by the number of votes, then by the shift.
    const int votes = bitCount(same);
    int at = candidates++;
    for (; at > 0; --at) {
      const int others = bitCount(voters[at - 1]);
      if (votes < others || votes == others && implied > candidate[at - 1]) break;
      candidate[at] = candidate[at - 1];
      voters[at] = voters[at - 1];
    }

    candidate[at] = implied;
    voters[at] = same;
  }
}

// Costs of a candidate for the cells of the surface.
float costs[cells], best_costs[cells];

float total(int c) {
  const uint others = surface & ~(1u << middle);
  float sum = costs[middle] + disagreement * float(bitCount(others & ~voters[c]));

  for (uint rest = others; rest != 0u; rest &= rest - 1u) {
    const int cell = findLSB(rest);
    const bool content = (voters[c] & 1u << cell) != 0u && shift[cell] == 0;
    if (!content) sum += min(costs[cell], most_evidence);
  }

  return sum;
}

// Largest cost advantages along a line: of the best over the candidate (x), and the reverse (y).
vec2 line_evidence(int c) {
  vec2 found = vec2(0.0);
  bool suited = false;

  for (int i = 0; i < line_count; ++i) {
    uint line = uint(words[vote.lines + i]);
    suited = suited || bitCount(line & voters[c] & ~(1u << middle)) > 1;

    float sum = 0.0;
    bool best_known = true, known = true;
    for (line &= surface; line != 0u; line &= line - 1u) {
      const int cell = findLSB(line);
      sum += best_costs[cell] - costs[cell];
      best_known = best_known && best_costs[cell] < infinite;
      known = known && costs[cell] < infinite;
    }

    if (best_known || known) found = max(found, vec2(-sum, sum));
  }

  return suited ? found : vec2(0.0);
}

int least_cost_shift() {
  name_candidates();

  int best = -1, chosen = 0;
  float least = 3.4e38, most = enough_along_a_line;

  // Twice over the candidates: first for the least total cost, then for lines that override it.
  for (int i = 0; i < 2 * candidates; ++i) {
    const int c = i % candidates;
    if (c == best && i >= candidates) continue;

    for (uint rest = surface; rest != 0u; rest &= rest - 1u) {
      const int cell = findLSB(rest);
      costs[cell] = against(cell, candidate[c] + shift_step[cell]);
    }

    if (costs[middle] > sure) continue;

    if (i < candidates) {
      const float sum = total(c);
      if (!(sum < least)) continue;
      best = c;
      chosen = candidate[c];
      least = sum;
      best_costs = costs;
      continue;
    }

    const vec2 evidence = line_evidence(c);
    const bool crossing = evidence.x > enough_along_a_line;
    if (!(evidence.y > most) || crossing && !(costs[middle] < best_costs[middle])) continue;
    chosen = candidate[c];
    most = evidence.y;
  }

  return chosen;
}

bool may_disagree(float y, int own) {
  const ivec2 beside[4] = ivec2[](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));

  for (int i = 0; i < 4; ++i) {
    const float step = periods_at(here + beside[i], y), whole = roundEven(step);
    if (abs(step - whole) <= steepest && step < no_coordinate &&
        shift_at(here + beside[i]) != own - int(whole)) {
      return true;
    }
  }

  return false;
}

bool disagrees(int own) {
  return (right & 1u << middle) != 0u && shift[middle + 1] != own + link_step[middle] ||
         (right & 1u << middle - 1) != 0u && shift[middle - 1] != own - link_step[middle - 1] ||
         (down & 1u << middle) != 0u && shift[middle + side] != own + link_step[cells + middle] ||
         (down & 1u << middle - side) != 0u &&
             shift[middle - side] != own - link_step[cells + middle - side];
}

int next_shift(float y) {
  // Pixels without a vote, and those with nothing to decide, keep their shift.
  const int own = shift_at(here);
  if (periods_at(here, y) >= no_coordinate) return own;
  if (task == choose ? !may_disagree(y, own) : own == 0) return own;

  // The surface of the pixel.
  look_around(y);
  if (task == choose && !disagrees(own)) return own;

  find_surface(task == choose ? whole_window : inner_window);
  if (task == choose) return least_cost_shift();

  // To restore: a neighbour that agrees with the pixel's own order supports it.
  for (uint rest = surface & ~(1u << middle); rest != 0u; rest &= rest - 1u) {
    const int cell = findLSB(rest);
    if (shift[cell] == shift_step[cell]) return 0;  // an edge of whole periods
  }

  return own;
}

void finish(int at) {
  const int by = int(between[place(chosen, at)]), fours = scan() * scan_fours + at / 4;
  const float y = kept_at(0, at) + float(by) * vote.period;

  uint flags = between[place(1, at)];
  if (by != 0) {
    // The doubt at the new order, and the maps.
    float periods = kept_at(5, at) - cue.periods * y;
    if (cost.form == circle) periods -= cue.periods * roundEven(periods * vote.period);
    const float doubt = min(abs(periods), 0.5);

    flags &= ~uint(doubtful_order);
    if (doubt > cue.largest_doubt) flags |= uint(doubtful_order);

    if (plane_at.coordinate >= 0) planes[4 * (plane_at.coordinate + fours) + at % 4] = y;
    if (plane_at.doubt >= 0) planes[4 * (plane_at.doubt + fours) + at % 4] = doubt;
  }

  // The mean without the cue's contribution.
  if (vote.shade != 0.0 && plane_at.mean >= 0) {
    planes[4 * (plane_at.mean + fours) + at % 4] -= vote.shade * kept_at(2, at) * reference(y);
  }

  between[place(0, at)] =
      floatBitsToUint((flags & uint(no_vote)) != 0u ? no_coordinate : y);
  between[place(1, at)] = flags;
}

void main() {
  for (int at = first_pixel(); at < min(first_pixel() + 4, pixel_count()); ++at) {
    if (task == choose || task == restore) {
      here = ivec2(at % width, at / width);
      between[place(next, at)] = uint(next_shift(kept_at(0, at)));
    } else if (task == settle) {
      between[place(chosen, at)] = between[place(next, at)];
    } else {
      finish(at);
    }
  }
}
