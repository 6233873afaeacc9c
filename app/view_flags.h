#pragma once

#include <string>

#include <CLI/App.hpp>

#include "slipstream/base/size.h"

namespace slipstream::view {
struct ViewSettings;
}

namespace slipstream::app {

/// The flags of all that draws clouds.
struct ViewFlags {
  std::string snapshot;    ///< file of a picture without panel; empty where none is wanted
  std::string screenshot;  ///< file of one with it
  std::string size = "1280x800";
  std::string colour = "reflectivity";
  std::string save_to = ".";
};

/// Adds --snapshot, --screenshot, --size, --colour and --save-to.
void add_view_flags(CLI::App& subcommand, ViewFlags& flags);

/// Throws Error for a picture file of unknown ending, a size or a colour that there is not.
void require_good(const ViewFlags& flags);
Size size_from(const ViewFlags& flags);
view::ViewSettings view_settings_from(const ViewFlags& flags);

}  // namespace slipstream::app
