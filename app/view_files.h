#pragma once

#include <string>

#include "app/output.h"
#include "app/view_flags.h"
#include "slipstream/view/viewer.h"

namespace slipstream::app {

/// Writes a picture and says so, under its name.
void write_picture(const char* name, const std::string& path, const Image<Colour>& picture,
                   Output& output);

/// Draws --snapshot and --screenshot without a window, as far as they are given.
void write_snapshot(const view::ViewSource& source, const ViewFlags& flags, Output& output);
void write_screenshot(const view::ViewSource& source, const ViewFlags& flags, Output& output);

}  // namespace slipstream::app
