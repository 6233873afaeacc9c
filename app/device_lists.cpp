// camera list and gpu list: what is there.
#include "app/commands.h"
#include "slipstream/base/error.h"
#include "slipstream/devices/camera.h"
#include "slipstream/reconstruct/gpu.h"

namespace slipstream::app {
namespace {

struct NoFlags {};

void list_connected(const NoFlags&, Output& output) {
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

void list_gpus(const NoFlags&, Output& output) {
  const std::vector<GpuDescription> devices = gpu_devices();
  output.document["devices"] = nlohmann::json::array();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const GpuDescription& device = devices[i];
    constexpr double mebibyte = 1 << 20;
    output.say("gpu:{}  {}, {:.0f} MiB, {}{}", i, device.name,
               static_cast<double>(device.memory) / mebibyte, device.driver,
               device.software ? "; software, on the processor's cores" : "");
    output.document["devices"].push_back({{"backend", fmt::format("gpu:{}", i)},
                                          {"name", device.name},
                                          {"driver", device.driver},
                                          {"software", device.software},
                                          {"memory_bytes", device.memory}});
  }
  if (!devices.empty()) return;
  try {
    Gpu::open(std::nullopt);
  } catch (const WorldError& why) {
    output.say("{}", why.what());
  }
}

}  // namespace

void add_camera(CLI::App& program, Command& chosen) {
  CLI::App* camera = program.add_subcommand("camera", "find cameras; serve a virtual one");
  camera->require_subcommand(1);
  add_command(*camera, chosen, list_connected, "list",
              "cameras that answer, as --source names them");
#ifdef SLIPSTREAM_CAMERAS
  add_camera_serve(*camera, chosen);
#endif
}

void add_gpu(CLI::App& program, Command& chosen) {
  CLI::App* const gpu = program.add_subcommand("gpu", "devices for --backend gpu");
  gpu->require_subcommand(1);
  add_command(*gpu, chosen, list_gpus, "list", "the devices that Vulkan finds, by number");
}

}  // namespace slipstream::app
