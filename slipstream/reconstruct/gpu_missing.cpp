// Stands in for gpu.cpp where Vulkan's headers or a compiler for its shaders are not installed.
#include "slipstream/reconstruct/gpu.h"

namespace slipstream {
namespace {

[[noreturn]] void refuse() {
  throw WorldError(
      "this program was built without Vulkan (libvulkan-dev and glslc, -DSLIPSTREAM_GPU=ON)");
}

}  // namespace

struct Gpu::Parts {};
struct GpuBuffer::Parts {};
struct GpuProgram::Parts {};
struct GpuRun::Parts {};

Gpu::~Gpu() = default;
GpuBuffer::GpuBuffer(std::shared_ptr<const Gpu>, std::size_t, GpuMemory) {
  refuse();
}
GpuBuffer::GpuBuffer(GpuBuffer&&) noexcept = default;
GpuBuffer& GpuBuffer::operator=(GpuBuffer&&) noexcept = default;
GpuBuffer::~GpuBuffer() = default;
GpuProgram::GpuProgram(std::shared_ptr<const Gpu>, std::span<const std::uint32_t>,
                       std::span<const std::uint32_t>) {
  refuse();
}
GpuProgram::GpuProgram(GpuProgram&&) noexcept = default;
GpuProgram& GpuProgram::operator=(GpuProgram&&) noexcept = default;
GpuProgram::~GpuProgram() = default;
GpuRun::GpuRun(std::shared_ptr<const Gpu>) {
  refuse();
}
GpuRun::GpuRun(GpuRun&&) noexcept = default;
GpuRun::~GpuRun() = default;

std::size_t GpuBuffer::size() const {
  refuse();
}
std::byte* GpuBuffer::data() const {
  refuse();
}
void GpuRun::start(std::span<const GpuBuffer* const>, std::span<const GpuProgram* const>,
                   std::uint64_t, std::uint32_t) {
  refuse();
}
void GpuRun::wait() {
  refuse();
}
std::shared_ptr<const Gpu> Gpu::open(std::optional<int>) {
  refuse();
}
const GpuDescription& Gpu::description() const {
  refuse();
}
std::size_t Gpu::most_bytes() const {
  refuse();
}
void Gpu::lose() const {}
std::vector<GpuDescription> gpu_devices() {
  return {};
}

}  // namespace slipstream
