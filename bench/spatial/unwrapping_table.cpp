// How often each unwrapping is right, how long it takes and what memory: the table of
// docs/unwrapping.md.
//
//   spatial_table [--small | --large] [--only METHOD] [--phase NAME]
//   spatial_table --npy FOLDER    writes the phases, for compare_skimage.py
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "slipstream/image/converted.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/spatial/spatial_unwrapping.h"
#include "tests/spatial/known_phase.h"

namespace slipstream {
namespace {
namespace fs = std::filesystem;

/// The most memory so far, MB; from now on if `anew`.
double peak_memory(bool anew) {
  if (anew) std::ofstream("/proc/self/clear_refs") << 5;
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "VmHWM:") continue;
    double kilobytes = 0;
    status >> kilobytes;
    return kilobytes / 1024;
  }
  return 0;
}

void measure(const std::string& method, const NamedPhase& phase, Size size) {
  const KnownPhase known = phase.make(size);
  const double before = peak_memory(true);
  const auto start = std::chrono::steady_clock::now();
  const UnwrappedPhase<float> unwrapped = unwrap_in_space(known.wrapped, {}, method);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  std::printf("%-13s %-9s %9s  right %8.4f %%  regions %7zu  %8.3f s  %6.0f MB\n", method.c_str(),
              phase.name.c_str(), text_of(size).c_str(), 100 * right_share(known, unwrapped.phase),
              unwrapped.regions.size(), took.count(), peak_memory(false) - before);
  std::fflush(stdout);
}

void write(const fs::path& folder, const NamedPhase& phase, Size size) {
  const KnownPhase known = phase.make(size);
  const std::string name = text_of(size) + "-" + phase.name;
  write_map(folder / (name + "-wrapped.npy"), known.wrapped);
  write_map(folder / (name + "-truth.npy"), known.truth);
  write_map(folder / (name + "-regions.npy"), converted<float>(regions_of(known.truth)));
}

}  // namespace
}  // namespace slipstream

int main(int argc, char** argv) {
  using namespace slipstream;
  std::string only, folder, scene;
  std::vector<Size> sizes{{640, 480}, {2592, 1944}};
  for (int i = 1; i < argc; ++i) {
    const std::string flag = argv[i];
    if (flag == "--small") sizes = {{640, 480}};
    if (flag == "--large") sizes = {{2592, 1944}};
    if (flag == "--only") only = argv[++i];
    if (flag == "--phase") scene = argv[++i];
    if (flag == "--npy") folder = argv[++i];
  }
  for (const Size size : sizes) {
    for (const NamedPhase& phase : known_phases()) {
      if (!scene.empty() && scene != phase.name) continue;
      if (!folder.empty()) {
        write(folder, phase, size);
        continue;
      }
      for (const SpatialUnwrapping& method : spatial_unwrappings()) {
        if (!only.empty() && only != method.name) continue;
        measure(std::string(method.name), phase, size);
      }
    }
  }
}
