#include "app/calibrate.h"

namespace slipstream::app {

void add_calibrate(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* calibrate = program.add_subcommand("calibrate", "find out what a real rig is like");
  calibrate->require_subcommand(1);
  add_calibrate_board(*calibrate, shared, chosen);
  add_calibrate_geometry(*calibrate, shared, chosen);
  add_calibrate_gamma(*calibrate, shared, chosen);
  add_calibrate_ambient(*calibrate, shared, chosen);
  add_calibrate_noise(*calibrate, shared, chosen);
}

}  // namespace slipstream::app
