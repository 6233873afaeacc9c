#include "slipstream/decode/closed_form.h"

namespace slipstream {
namespace {

constexpr std::array<ClosedForm, 3> closed_forms{{
    {.steps = 3, .u = {2, -1, -1}, .v = {0, 1, -1}, .divisor = 3, .sine_square = 3},
    {.steps = 4, .u = {1, 0, -1, 0}, .v = {0, 1, 0, -1}, .divisor = 2, .sine_square = 1},
    {.steps = 6,
     .u = {2, 1, -1, -2, -1, 1},
     .v = {0, 1, 1, 0, -1, -1},
     .divisor = 6,
     .sine_square = 3},
}};

}  // namespace

const ClosedForm* closed_form(int steps) {
  for (const ClosedForm& form : closed_forms) {
    if (form.steps == steps) return &form;
  }
  return nullptr;
}

}  // namespace slipstream
