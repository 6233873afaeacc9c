#include "reconstruct/gpu.h"

#ifdef SLIPSTREAM_GPU

#include <algorithm>
#include <array>
#include <initializer_list>
#include <map>
#include <mutex>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>
#include <vulkan/vulkan_raii.hpp>

#include "base/system_failure.h"

namespace slipstream {
namespace {

/// Calls the driver; its errors become GpuError.
template <class Call>
auto driver_call(const Call& call) -> decltype(call()) try {
  return call();
} catch (const vk::SystemError& error) {
  const std::error_code code = error.code();
  const bool no_memory = code == vk::Result::eErrorOutOfDeviceMemory ||
                         code == vk::Result::eErrorOutOfHostMemory ||
                         code == vk::Result::eErrorTooManyObjects;
  throw GpuError(no_memory ? GpuFailure::no_memory : GpuFailure::lost,
                 fmt::format("the GPU has failed: {}", error.what()));
}

constexpr std::uint32_t least_version = VK_API_VERSION_1_1;

/// The Vulkan loader, found at run time, and its devices.
struct Loader {
  vk::raii::Context context;
  vk::raii::Instance instance{nullptr};
  std::vector<vk::raii::PhysicalDevice> devices;

  Loader() {
    const vk::ApplicationInfo application("slipstream", 0, nullptr, 0, least_version);

    instance = vk::raii::Instance(context, vk::InstanceCreateInfo({}, &application));
    for (auto& device : vk::raii::PhysicalDevices(instance)) devices.push_back(std::move(device));
  }
};

/// One per program. Never destroyed: the driver may be gone before the program's last statics.
const Loader& loader() {
  static const Loader* const shared = new Loader;
  return *shared;
}

GpuDescription describe(const vk::raii::PhysicalDevice& device) {
  const vk::PhysicalDeviceProperties own = device.getProperties();

  GpuDescription description{.name = own.deviceName.data(),
                             .software = own.deviceType == vk::PhysicalDeviceType::eCpu,
                             .discrete = own.deviceType == vk::PhysicalDeviceType::eDiscreteGpu};

  // Vulkan 1.0 cannot name the driver.
  if (own.apiVersion >= least_version) {
    const auto chain =
        device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties>();
    const auto& driver = chain.get<vk::PhysicalDeviceDriverProperties>();
    description.driver = fmt::format("{} {}", driver.driverName.data(), driver.driverInfo.data());
  }

  // The device's own memory.
  for (const vk::MemoryHeap& heap : device.getMemoryProperties().memoryHeaps) {
    if (heap.flags & vk::MemoryHeapFlagBits::eDeviceLocal) description.memory += heap.size;
  }
  return description;
}

void require_large_enough(const vk::raii::PhysicalDevice& device) {
  const vk::PhysicalDeviceProperties own = device.getProperties();
  if (own.apiVersion >= least_version &&
      own.limits.maxPerStageDescriptorStorageBuffers >= GpuProgram::most_buffers &&
      own.limits.maxComputeWorkGroupSize[0] >= GpuProgram::group_size &&
      own.limits.maxComputeWorkGroupInvocations >= GpuProgram::group_size) {
    return;
  }

  throw GpuError(
      GpuFailure::too_small,
      fmt::format("{} is not supported: requires Vulkan 1.1, {} buffers and work groups of {}",
                  own.deviceName.data(), GpuProgram::most_buffers, GpuProgram::group_size));
}

/// Index of the first queue family that computes.
std::uint32_t compute_queues(const vk::raii::PhysicalDevice& device) {
  const auto families = device.getQueueFamilyProperties();

  for (std::uint32_t i = 0; i < families.size(); ++i) {
    if (families[i].queueFlags & vk::QueueFlagBits::eCompute) return i;
  }

  throw GpuError(GpuFailure::too_small, "the GPU has no compute queue");
}

vk::raii::Device device_of(const vk::raii::PhysicalDevice& physical, std::uint32_t family) {
  require_large_enough(physical);

  const float priority = 1;
  const vk::DeviceQueueCreateInfo queue({}, family, 1, &priority);
  return {physical, vk::DeviceCreateInfo({}, queue)};
}

vk::raii::DescriptorSetLayout buffer_layout(const vk::raii::Device& device) {
  std::array<vk::DescriptorSetLayoutBinding, GpuProgram::most_buffers> bindings;

  for (std::uint32_t i = 0; i < bindings.size(); ++i) {
    bindings[i] = vk::DescriptorSetLayoutBinding(i, vk::DescriptorType::eStorageBuffer, 1,
                                                 vk::ShaderStageFlagBits::eCompute);
  }

  return {device, vk::DescriptorSetLayoutCreateInfo({}, bindings)};
}

/// Suitable kinds of memory, best first.
std::initializer_list<vk::MemoryPropertyFlags> kinds_for(GpuMemory memory) {
  using Flag = vk::MemoryPropertyFlagBits;
  static constexpr vk::MemoryPropertyFlags seen = Flag::eHostVisible | Flag::eHostCoherent;
  static constexpr std::initializer_list<vk::MemoryPropertyFlags> own{Flag::eDeviceLocal, {}},
      up{seen | Flag::eDeviceLocal, seen},
      down{seen | Flag::eHostCached, Flag::eHostVisible | Flag::eHostCached, seen};

  return memory == GpuMemory::device ? own : memory == GpuMemory::upload ? up : down;
}

}  // namespace

struct Gpu::Parts {
  explicit Parts(const vk::raii::PhysicalDevice& of)
      : physical(of),
        family(compute_queues(physical)),
        device(device_of(physical, family)),
        queue(device, family, 0),
        set_layout(buffer_layout(device)),
        layout(device, vk::PipelineLayoutCreateInfo({}, *set_layout)),
        limits(physical.getProperties().limits) {}

  vk::raii::PhysicalDevice physical;
  std::uint32_t family;
  vk::raii::Device device;
  std::mutex mutex{};  ///< guards the queue
  vk::raii::Queue queue;
  vk::raii::DescriptorSetLayout set_layout;
  vk::raii::PipelineLayout layout;
  vk::PhysicalDeviceLimits limits;
};

struct GpuBuffer::Parts {
  std::shared_ptr<const Gpu> gpu;
  vk::raii::Buffer buffer{nullptr};
  vk::raii::DeviceMemory memory{nullptr};
  bool mapped = false;
  bool coherent = true;  ///< the host sees the device's writes without invalidation

  /// Allocates memory of a kind; false if it is used up.
  bool take(const vk::MemoryRequirements& wanted, vk::MemoryPropertyFlags kind) {
    const auto all = gpu->parts_->physical.getMemoryProperties();
    for (std::uint32_t i = 0; i < all.memoryTypeCount; ++i) {
      // AMD's device-coherent memory is slower, and barriers make it unnecessary.
      using Flag = vk::MemoryPropertyFlagBits;
      const vk::MemoryPropertyFlags flags = all.memoryTypes[i].propertyFlags;
      const bool fits = (wanted.memoryTypeBits >> i & 1U) != 0;
      const bool slow = static_cast<bool>(flags & Flag::eDeviceCoherentAMD);
      if (!fits || slow || (flags & kind) != kind) continue;

      // If this heap is full, try the next kind of memory.
      try {
        memory =
            vk::raii::DeviceMemory(gpu->parts_->device, vk::MemoryAllocateInfo(wanted.size, i));
        coherent = static_cast<bool>(flags & Flag::eHostCoherent);
        return true;
      } catch (const vk::OutOfDeviceMemoryError&) {
      } catch (const vk::OutOfHostMemoryError&) {
      }
    }

    return false;
  }
};

GpuBuffer::GpuBuffer(std::shared_ptr<const Gpu> gpu, std::size_t bytes, GpuMemory memory)
    : size_(bytes), parts_(std::make_shared<Parts>(Parts{.gpu = std::move(gpu)})) {
  const Gpu& own = *parts_->gpu;
  const std::string& name = own.description().name;

  // 1. The device may not support a buffer of this size.
  if (bytes > own.most_bytes()) {
    throw GpuError(GpuFailure::too_small,
                   fmt::format("{} supports buffers of up to {} bytes; {} are required", name,
                               own.most_bytes(), bytes));
  }

  // 2. The buffer. Vulkan does not allow 0 bytes.
  driver_call([&] {
    parts_->buffer = vk::raii::Buffer(
        own.parts_->device, vk::BufferCreateInfo({}, std::max<std::size_t>(bytes, 4),
                                                 vk::BufferUsageFlagBits::eStorageBuffer));

    // 3. Memory of the best kind that has room.
    const vk::MemoryRequirements wanted = parts_->buffer.getMemoryRequirements();
    const auto kinds = kinds_for(memory);
    if (std::none_of(kinds.begin(), kinds.end(),
                     [&](auto kind) { return parts_->take(wanted, kind); })) {
      throw GpuError(GpuFailure::no_memory,
                     fmt::format("{} has no memory left for {} bytes", name, bytes));
    }
    parts_->buffer.bindMemory(*parts_->memory, 0);

    // 4. The host's view of it.
    if (memory == GpuMemory::device) return;
    parts_->mapped = true;
    data_ = static_cast<std::byte*>(parts_->memory.mapMemory(0, VK_WHOLE_SIZE));
  });
}

struct GpuProgram::Parts {
  std::shared_ptr<const Gpu> gpu;
  vk::raii::Pipeline pipeline{nullptr};
};

GpuProgram::GpuProgram(std::shared_ptr<const Gpu> gpu, std::span<const std::uint32_t> spirv,
                       std::span<const std::uint32_t> constants)
    : parts_(std::make_shared<Parts>(Parts{.gpu = std::move(gpu)})) {
  const Gpu::Parts& own = *parts_->gpu->parts_;

  // The constants, numbered from 0.
  std::vector<vk::SpecializationMapEntry> entries;
  for (std::uint32_t i = 0; i < constants.size(); ++i) {
    entries.emplace_back(i, i * std::uint32_t{sizeof(std::uint32_t)}, sizeof(std::uint32_t));
  }
  const vk::SpecializationInfo special(static_cast<std::uint32_t>(entries.size()), entries.data(),
                                       constants.size_bytes(), constants.data());

  // Compile the shader with them.
  driver_call([&] {
    const vk::raii::ShaderModule module(
        own.device, vk::ShaderModuleCreateInfo({}, spirv.size_bytes(), spirv.data()));
    const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module,
                                                  "main", &special);
    parts_->pipeline = vk::raii::Pipeline(own.device, nullptr,
                                          vk::ComputePipelineCreateInfo({}, stage, *own.layout));
  });
}

struct GpuRun::Parts {
  explicit Parts(std::shared_ptr<const Gpu> of) : gpu(std::move(of)) {
    const Gpu::Parts& own = *gpu->parts_;

    // A set that names the buffers.
    static constexpr vk::DescriptorPoolSize size(vk::DescriptorType::eStorageBuffer,
                                                 GpuProgram::most_buffers);
    sets = {own.device, vk::DescriptorPoolCreateInfo(
                            vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 1, size)};
    set = std::move(
        vk::raii::DescriptorSets(own.device, vk::DescriptorSetAllocateInfo(*sets, *own.set_layout))
            .front());

    // The commands, and a fence that signals their end.
    commands = {own.device, vk::CommandPoolCreateInfo(
                                vk::CommandPoolCreateFlagBits::eResetCommandBuffer, own.family)};
    command = std::move(
        vk::raii::CommandBuffers(own.device, vk::CommandBufferAllocateInfo(
                                                 *commands, vk::CommandBufferLevel::ePrimary, 1))
            .front());
    done = {own.device, vk::FenceCreateInfo()};
  }

  /// Binds a buffer everywhere: unused bindings get the first one.
  void bind() {
    std::array<vk::DescriptorBufferInfo, GpuProgram::most_buffers> infos;
    for (std::size_t i = 0; i < infos.size(); ++i) {
      infos[i] =
          vk::DescriptorBufferInfo(*buffers[i < buffers.size() ? i : 0]->buffer, 0, VK_WHOLE_SIZE);
    }

    gpu->parts_->device.updateDescriptorSets(
        vk::WriteDescriptorSet(*set, 0, 0, vk::DescriptorType::eStorageBuffer, {}, infos), {});
  }

  void dispatch(const vk::raii::Pipeline& pipeline, std::uint64_t groups, std::uint32_t layers) {
    // A device allows a limited number of groups in a row, so the groups fill several rows.
    const std::uint64_t most = gpu->parts_->limits.maxComputeWorkGroupCount[0];
    const std::uint64_t rows = (groups + most - 1) / most;

    command.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
    command.dispatch(static_cast<std::uint32_t>((groups + rows - 1) / rows),
                     static_cast<std::uint32_t>(rows), layers);
  }

  void before(vk::PipelineStageFlags next, vk::AccessFlags access) {
    const vk::MemoryBarrier written(vk::AccessFlagBits::eShaderWrite, access);
    command.pipelineBarrier(vk::PipelineStageFlagBits::eComputeShader, next, {}, written, {}, {});
  }

  void submit() {
    Gpu::Parts& own = *gpu->parts_;
    if (gpu->lost_) {
      throw GpuError(GpuFailure::lost, fmt::format("{} is lost", gpu->description().name));
    }

    own.device.resetFences(*done);
    const std::lock_guard lock(own.mutex);
    own.queue.submit(vk::SubmitInfo({}, {}, *command), *done);
    runs = true;
  }

  void wait(std::uint64_t longest) {
    if (!runs) return;

    const Gpu::Parts& own = *gpu->parts_;
    try {
      if (own.device.waitForFences(*done, VK_TRUE, longest) != vk::Result::eSuccess) {
        throw GpuError(GpuFailure::lost,
                       fmt::format("{} does not answer", gpu->description().name));
      }
    } catch (const vk::DeviceLostError&) {  // nothing runs there any more
      runs = false;
      throw;
    }

    runs = false;

    // Let the host see the results in memory that is not coherent.
    std::vector<vk::MappedMemoryRange> written;
    for (const auto& buffer : buffers) {
      if (!buffer->mapped || buffer->coherent) continue;
      written.emplace_back(*buffer->memory, 0, VK_WHOLE_SIZE);
    }
    if (!written.empty()) own.device.invalidateMappedMemoryRanges(written);
  }

  std::shared_ptr<const Gpu> gpu;
  std::vector<std::shared_ptr<const GpuBuffer::Parts>> buffers;
  std::vector<std::shared_ptr<const GpuProgram::Parts>> programs;
  vk::raii::DescriptorPool sets{nullptr};
  vk::raii::DescriptorSet set{nullptr};
  vk::raii::CommandPool commands{nullptr};
  vk::raii::CommandBuffer command{nullptr};
  vk::raii::Fence done{nullptr};
  static constexpr std::uint64_t usual_wait = 10'000'000'000;  ///< ns
  bool runs = false;
  Parts* kept_before = nullptr;  ///< see `end`

  static void end(Parts* own) {
    try {
      own->wait(own->gpu->lost_ ? 0 : usual_wait);
    } catch (const std::runtime_error&) {
    }
    if (!own->runs) return delete own;

    // The device may still write there: kept for good, in a list so that leak checkers find it.
    static std::atomic<Parts*> kept = nullptr;
    own->kept_before = kept.exchange(own);
  }
};

GpuRun::GpuRun(std::shared_ptr<const Gpu> gpu)
    : parts_(driver_call([&] { return new Parts(std::move(gpu)); }), Parts::end) {}

void GpuRun::start(std::span<const GpuBuffer* const> buffers,
                   std::span<const GpuProgram* const> programs, std::uint64_t invocations,
                   std::uint32_t layers) {
  driver_call([&] {
    // 1. Keep the buffers and programs until the run ends.
    parts_->buffers.clear();
    parts_->programs.clear();
    for (const GpuBuffer* buffer : buffers) parts_->buffers.push_back(buffer->parts_);
    for (const GpuProgram* program : programs) parts_->programs.push_back(program->parts_);

    parts_->bind();
    parts_->command.begin(
        vk::CommandBufferBeginInfo(vk::CommandBufferUsageFlagBits::eOneTimeSubmit));
    parts_->command.bindDescriptorSets(vk::PipelineBindPoint::eCompute,
                                       *parts_->gpu->parts_->layout, 0, *parts_->set, {});

    // 2. The programs in turn: each waits for the results of the one before.
    const std::uint64_t groups =
        (invocations + GpuProgram::group_size - 1) / GpuProgram::group_size;
    for (const GpuProgram* program : programs) {
      if (program != programs.front()) {
        parts_->before(vk::PipelineStageFlagBits::eComputeShader,
                       vk::AccessFlagBits::eShaderRead | vk::AccessFlagBits::eShaderWrite);
      }
      parts_->dispatch(program->parts_->pipeline, groups, layers);
    }

    // 3. The host reads the last results.
    parts_->before(vk::PipelineStageFlagBits::eHost, vk::AccessFlagBits::eHostRead);
    parts_->command.end();
    parts_->submit();
  });
}

void GpuRun::wait() {
  driver_call([&] { parts_->wait(Parts::usual_wait); });
}

Gpu::Gpu(int number) {
  const vk::raii::PhysicalDevice& device = loader().devices[static_cast<std::size_t>(number)];
  description_ = describe(device);
  parts_ = std::make_shared<Parts>(device);
  most_bytes_ = parts_->limits.maxStorageBufferRange;
}

std::shared_ptr<const Gpu> Gpu::open(std::optional<int> number) {
  const std::vector<GpuDescription> devices = gpu_devices();
  if (devices.empty()) throw WorldError("Vulkan finds no GPU on this machine");

  // The best device: hardware before software, discrete before integrated.
  if (!number) {
    const auto best =
        std::min_element(devices.begin(), devices.end(), [](const auto& device, const auto& other) {
          return std::pair(device.software, !device.discrete) <
                 std::pair(other.software, !other.discrete);
        });
    number = static_cast<int>(best - devices.begin());
  }

  if (*number < 0 || static_cast<std::size_t>(*number) >= devices.size()) {
    throw WorldError(fmt::format("there is no GPU {}; this machine has {}, counted from 0", *number,
                                 devices.size()));
  }

  // Opening a device takes long, and drivers allow few at a time.
  static std::mutex mutex;
  static std::map<int, std::weak_ptr<const Gpu>> open;

  const std::lock_guard lock(mutex);
  if (auto shared = open[*number].lock(); shared && !shared->lost_) return shared;

  std::shared_ptr<const Gpu> gpu(driver_call([&] { return new Gpu(*number); }));
  open[*number] = gpu;
  return gpu;
}

std::vector<GpuDescription> gpu_devices() {
  std::vector<GpuDescription> devices;
  require_descriptors(32, "the GPU's driver");  // without them it finds no device, or crashes
  try {
    for (const auto& device : loader().devices) devices.push_back(describe(device));
  } catch (const std::runtime_error&) {  // no loader or no driver: no devices
  }
  return devices;
}

}  // namespace slipstream

#else  // Vulkan's headers or a compiler for its shaders are not installed

namespace slipstream {

std::vector<GpuDescription> gpu_devices() {
  return {};
}

std::shared_ptr<const Gpu> Gpu::open(std::optional<int>) {
  throw WorldError(
      "this program was built without Vulkan (libvulkan-dev and glslc, -DSLIPSTREAM_GPU=ON)");
}

// Never called, because no device is ever open.
GpuBuffer::GpuBuffer(std::shared_ptr<const Gpu>, std::size_t, GpuMemory) {}
GpuProgram::GpuProgram(std::shared_ptr<const Gpu>, std::span<const std::uint32_t>,
                       std::span<const std::uint32_t>) {}
GpuRun::GpuRun(std::shared_ptr<const Gpu>) {}
void GpuRun::start(std::span<const GpuBuffer* const>, std::span<const GpuProgram* const>,
                   std::uint64_t, std::uint32_t) {}
void GpuRun::wait() {}

}  // namespace slipstream

#endif
