#include "app/commands.h"
#include "slipstream/devices/open_camera.h"

namespace slipstream::app {
namespace {

struct ListFlags {};

void list(const ListFlags&, Output& output) {
  output.document = {{"cameras", nlohmann::json::array()}};
  for (const CameraDescription& camera : list_cameras()) {
    output.say("{}  {} {} {}, {} {}", camera.name, camera.vendor, camera.model, camera.serial,
               camera.protocol, camera.address);
    output.list("cameras").push_back({{"source", camera.name},
                                      {"vendor", camera.vendor},
                                      {"model", camera.model},
                                      {"serial", camera.serial},
                                      {"protocol", camera.protocol},
                                      {"address", camera.address}});
  }
  if (output.document["cameras"].empty()) output.say("no camera answers");
}

}  // namespace

void add_camera(CLI::App& program, Command& chosen) {
  CLI::App* camera = program.add_subcommand("camera", "find cameras; serve a virtual one");
  camera->require_subcommand(1);
  add_command(*camera, chosen, list, "list", "cameras that answer, as --source names them");
#ifdef SLIPSTREAM_CAMERAS
  add_camera_serve(*camera, chosen);
#endif
}

}  // namespace slipstream::app
