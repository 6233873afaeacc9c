#include "app/commands.h"

namespace slipstream::app {

void add_calibrate(CLI::App& program, Command& chosen) {
  CLI::App* calibrate = program.add_subcommand("calibrate", "find out what a real rig is like");
  calibrate->require_subcommand(1);
  add_calibrate_board(*calibrate, chosen);
  add_calibrate_geometry(*calibrate, chosen);
  add_calibrate_verify(*calibrate, chosen);
  add_calibrate_gamma(*calibrate, chosen);
  add_calibrate_ambient(*calibrate, chosen);
  add_calibrate_noise(*calibrate, chosen);
  add_calibrate_colour(*calibrate, chosen);
  add_calibrate_height(*calibrate, chosen);
}

}  // namespace slipstream::app
