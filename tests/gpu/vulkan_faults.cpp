// Stands before the system's libvulkan.so.1 on LD_LIBRARY_PATH and passes all calls on but one:
// SLIPSTREAM_GPU_FAULT="vkQueueSubmit 5 -4" has the fifth call and all later ones return -4,
// VK_ERROR_DEVICE_LOST. Of vkGetPhysicalDeviceProperties the number is that of the buffers which a
// shader may have.
#include <atomic>
#include <cstdlib>
#include <sstream>
#include <string>

#include <dlfcn.h>
#include <vulkan/vulkan.h>

namespace {

struct Fault {
  std::string name;
  int from = 1, result = 0;
  std::atomic<int> calls = 0;

  Fault() {
    if (const char* const text = std::getenv("SLIPSTREAM_GPU_FAULT")) {
      std::istringstream(text) >> name >> from >> result;
    }
  }
  /// Counts the call.
  bool comes() { return ++calls >= from; }
};
Fault fault;

PFN_vkGetDeviceProcAddr device_call;
PFN_vkVoidFunction real;  // what `fault` names

VkResult submit(VkQueue queue, std::uint32_t count, const VkSubmitInfo* infos, VkFence fence) {
  if (fault.comes()) return VkResult(fault.result);
  return reinterpret_cast<PFN_vkQueueSubmit>(real)(queue, count, infos, fence);
}

VkResult allocate(VkDevice device, const VkMemoryAllocateInfo* info,
                  const VkAllocationCallbacks* callbacks, VkDeviceMemory* memory) {
  if (fault.comes()) return VkResult(fault.result);
  return reinterpret_cast<PFN_vkAllocateMemory>(real)(device, info, callbacks, memory);
}

/// What runs has ended all the same: nothing else would be freed in peace.
VkResult wait(VkDevice device, std::uint32_t count, const VkFence* fences, VkBool32 all,
              std::uint64_t longest) {
  const VkResult result =
      reinterpret_cast<PFN_vkWaitForFences>(real)(device, count, fences, all, longest);
  return fault.comes() ? VkResult(fault.result) : result;
}

void describe(VkPhysicalDevice device, VkPhysicalDeviceProperties* properties) {
  reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(real)(device, properties);
  if (!fault.comes()) return;
  properties->limits.maxPerStageDescriptorStorageBuffers = std::uint32_t(fault.result);
}

template <class Call>
PFN_vkVoidFunction instead(PFN_vkVoidFunction of, Call by) {
  real = of;
  return reinterpret_cast<PFN_vkVoidFunction>(by);
}

PFN_vkVoidFunction device_call_or_fault(VkDevice device, const char* name) {
  if (name == std::string("vkGetDeviceProcAddr")) {
    return reinterpret_cast<PFN_vkVoidFunction>(device_call_or_fault);
  }
  const PFN_vkVoidFunction found = device_call(device, name);
  if (found == nullptr || name != fault.name) return found;
  if (fault.name == "vkQueueSubmit") return instead(found, submit);
  if (fault.name == "vkAllocateMemory") return instead(found, allocate);
  return fault.name == "vkWaitForFences" ? instead(found, wait) : found;
}

}  // namespace

extern "C" PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance, const char* name) {
  static const auto pass_on = reinterpret_cast<PFN_vkGetInstanceProcAddr>(
      ::dlsym(::dlopen("libvulkan.so.1", RTLD_NOW), "vkGetInstanceProcAddr"));
  const PFN_vkVoidFunction found = pass_on(instance, name);
  if (found != nullptr && name == std::string("vkGetDeviceProcAddr")) {
    device_call = reinterpret_cast<PFN_vkGetDeviceProcAddr>(found);
    return reinterpret_cast<PFN_vkVoidFunction>(device_call_or_fault);
  }
  const bool describes = fault.name == "vkGetPhysicalDeviceProperties" && name == fault.name;
  return describes && found != nullptr ? instead(found, describe) : found;
}
