// The program on a GPU: as on the processor, on several, and on one that fails.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <vulkan/vulkan_raii.hpp>

#include "reconstruct/gpu.h"
#include "tests/app/program.h"
#include "tests/base/variable.h"

namespace slipstream::gpu_program_test {

namespace fs = std::filesystem;

std::size_t count_of(const std::string& words, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) {
    ++count;
  }
  return count;
}

class GpuProgram : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_FALSE(gpu_devices().empty()) << "mesa-vulkan-drivers is not installed";
    ASSERT_EQ(run_program({"simulate", path("scan"), "--camera", "96x72"}).exit_code, 0);
  }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  /// The words of a run that succeeds. A layer that validates writes on stdout.
  static std::string words_of(const std::vector<std::string>& arguments) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    for (const char* complaint : {"VUID-", "UNASSIGNED-", "SYNC-HAZARD"}) {
      EXPECT_EQ(run.out.find(complaint), std::string::npos) << run.out;
    }
    return run.out + run.err;
  }
  [[nodiscard]] std::string reconstruct(const std::string& backend) const {
    return words_of({"reconstruct", path("scan"), "--backend", backend});
  }
  [[nodiscard]] std::string live(const std::string& frames) const {
    return words_of({"live", "--source", "replay:" + path("scan"), "--loop", "--rate", "0",
                     "--frames", frames, "--headless", "--backend", "gpu"});
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(GpuProgram, GivesThePointsOfTheProcessor) {
  const std::string gpu = reconstruct("gpu"), fused = reconstruct("fused");
  const auto points = [](const std::string& words) { return words.substr(0, words.find(',')); };
  EXPECT_NE(gpu.find("backend gpu\n"), std::string::npos) << gpu;
  EXPECT_EQ(points(gpu), points(fused));
  const std::string words = live("30");
  EXPECT_NE(words.find("backend gpu;"), std::string::npos) << words;
  EXPECT_EQ(words.find("continuing on the CPU"), std::string::npos) << words;
}

/// Mesa's driver, named twice, is two devices.
TEST_F(GpuProgram, TakesOneOfSeveral) {
  std::string drivers;
  const fs::path folder = "/usr/share/vulkan/icd.d";
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (!entry.path().filename().string().starts_with("lvp_icd")) continue;
    fs::copy_file(entry.path(), path("again.json"));
    drivers = entry.path().string() + ":" + path("again.json");
  }
  ASSERT_FALSE(drivers.empty()) << "mesa-vulkan-drivers is not installed";
  const Variable files("VK_ICD_FILENAMES", drivers);
  const std::string first = reconstruct("gpu:0"), second = reconstruct("gpu:1");
  EXPECT_NE(first.find("backend gpu\n"), std::string::npos) << first;
  EXPECT_NE(second.find("backend gpu\n"), std::string::npos) << second;
  const ProgramRun third = run_program({"reconstruct", path("scan"), "--backend", "gpu:2"});
  EXPECT_EQ(third.exit_code, 1);
  EXPECT_EQ(third.err, "slipstream: there is no GPU 2; this machine has 2, counted from 0\n");
}

struct Failing {
  const char* name;
  const char* call;
  int result;      ///< see vulkan_faults.cpp
  int in_the_end;  ///< the call that fails in a live run: one of its middle, or of its last buffers
  std::string said;
};

void PrintTo(const Failing& failing, std::ostream* out) {
  *out << failing.name;
}

class GpuProgramFailing : public GpuProgram, public testing::WithParamInterface<Failing> {
 protected:
  static Variable fault(int from) {
    const Failing& failing = GetParam();
    return {"SLIPSTREAM_GPU_FAULT", fmt::format("{} {} {}", failing.call, from, failing.result)};
  }
  static void expect_said_once(const std::string& words) {
    for (const std::string& part : {"warning: " + GetParam().said, std::string("warning: "),
                                    std::string("; continuing on the CPU\n")}) {
      EXPECT_EQ(count_of(part, words), 1U) << part << " in\n" << words;
    }
  }
};

/// One line, and the points of the processor; a live run has a cloud of every window.
TEST_P(GpuProgramFailing, GoesOn) {
  const std::string fused = reconstruct("fused");
  const Variable library("LD_LIBRARY_PATH", SLIPSTREAM_GPU_FAULTS);
  {
    const Variable first = fault(1);
    const std::string words = reconstruct("gpu");
    expect_said_once(words);
    EXPECT_NE(words.find(fused.substr(0, fused.find('\n'))), std::string::npos) << words;
  }
  const Variable later = fault(GetParam().in_the_end);
  const std::string words = live("60");
  expect_said_once(words);
  EXPECT_NE(words.find("55 clouds"), std::string::npos) << words;
  EXPECT_NE(words.find("backend fused; 0 windows lost"), std::string::npos) << words;
}

const std::string device = gpu_devices().empty() ? "" : gpu_devices().front().name;

INSTANTIATE_TEST_SUITE_P(
    Faults, GpuProgramFailing,
    testing::Values(Failing{"lost", "vkQueueSubmit", -4, 30,
                            "the GPU has failed: vk::Queue::submit: ErrorDeviceLost"},
                    Failing{"lost_while_it_computes", "vkWaitForFences", -4, 30,
                            "the GPU has failed: vk::Device::waitForFences: ErrorDeviceLost"},
                    Failing{"silent", "vkWaitForFences", 2, 30, device + " does not answer"},
                    Failing{"full", "vkAllocateMemory", -2, 6, device + " has no memory left for"},
                    Failing{"small", "vkGetPhysicalDeviceProperties", 4, 1,
                            device + " is not supported: requires Vulkan 1.1, 6 buffers"}),
    [](const auto& info) { return std::string(info.param.name); });

/// Without it the tests of this folder would be silent whatever the shaders do.
TEST_F(GpuProgram, IsValidated) {
  const char* const wanted = std::getenv("VK_INSTANCE_LAYERS");
  ASSERT_NE(wanted, nullptr) << "VK_INSTANCE_LAYERS names no layer; ctest sets it";
  const auto layers = vk::raii::Context().enumerateInstanceLayerProperties();
  EXPECT_TRUE(std::any_of(layers.begin(), layers.end(),
                          [&](const vk::LayerProperties& layer) {
                            return std::string(layer.layerName.data()) == wanted;
                          }))
      << wanted << " is not installed";
}

}  // namespace slipstream::gpu_program_test
