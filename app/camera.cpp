#include <algorithm>
#include <vector>

#include "app/commands.h"
#include "app/genicam.h"
#include "slipstream/capture/v4l2_source.h"

namespace slipstream::app {
namespace {

void list(Output& output) {
  output.document = {{"cameras", nlohmann::json::array()}};
  const auto tell = [&](const char* source, const CameraDescription& camera) {
    output.say("{}:{}  {} {} {}, {} {}", source, camera.name, camera.vendor, camera.model,
               camera.serial, camera.protocol, camera.address);
    output.document["cameras"].push_back({{"source", std::string(source) + ":" + camera.name},
                                          {"vendor", camera.vendor},
                                          {"model", camera.model},
                                          {"serial", camera.serial},
                                          {"protocol", camera.protocol},
                                          {"address", camera.address}});
  };
  for (const CameraDescription& camera : genicam_cameras()) tell("aravis", camera);
  for (const CameraDescription& camera : list_v4l2_cameras()) tell("v4l2", camera);
  if (output.document["cameras"].empty()) output.say("no camera answers");
}

void add_list(CLI::App& camera, SharedFlags& shared, Command& chosen) {
  CLI::App* command = camera.add_subcommand("list", "cameras that answer, as --source names them");
  add_shared_flags(*command, shared);
  command->callback([&chosen] { chosen = [](Output& output) { list(output); }; });
}

}  // namespace

void add_camera(CLI::App& program, SharedFlags& shared, Command& chosen) {
  CLI::App* camera = program.add_subcommand("camera", "find cameras; serve a virtual one");
  camera->require_subcommand(1);
  add_list(*camera, shared, chosen);
  add_camera_serve(*camera, shared, chosen);
}

}  // namespace slipstream::app
