#include "app/calibrate.h"

namespace slipstream::app {

void add_calibrate(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* group = program.add_subcommand("calibrate", "measure what a scanner file holds");
  group->require_subcommand(1);
  add_calibrate_ambient(*group, shared, chosen);
  add_calibrate_gamma(*group, shared, chosen);
  add_calibrate_noise(*group, shared, chosen);
}

}  // namespace slipstream::app
