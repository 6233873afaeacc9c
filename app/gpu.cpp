#include "slipstream/reconstruct/gpu.h"

#include "app/commands.h"

namespace slipstream::app {
namespace {

struct GpuFlags {};

void list(const GpuFlags&, Output& output) {
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

void add_gpu(CLI::App& program, Command& chosen) {
  CLI::App* const gpu = program.add_subcommand("gpu", "devices for --backend gpu");
  gpu->require_subcommand(1);
  add_command(*gpu, chosen, list, "list", "the devices that Vulkan finds, by number");
}

}  // namespace slipstream::app
