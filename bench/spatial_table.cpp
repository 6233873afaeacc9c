// Success rate, time and memory of each unwrapping: the table of docs/how-to/unwrap-phase-maps.md.
//
//   spatial_table [--small | --large] [--only METHOD] [--phase NAME]     METHOD may be opencv
//   spatial_table --npy FOLDER    writes the phases, for compare_skimage.py
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#ifdef SLIPSTREAM_OPENCV_PHASE_UNWRAPPING
#include <opencv2/phase_unwrapping/histogramphaseunwrapping.hpp>
#endif

#include "io/file.h"
#include "io/image_file.h"
#include "slipstream/image.h"
#include "slipstream/spatial_unwrapping.h"
#include "tests/spatial/known_phase.h"

namespace slipstream {
namespace {
namespace fs = std::filesystem;

/// Peak memory, MB; resets the peak first if `restart`.
double peak_memory(bool restart) {
  if (restart) std::ofstream("/proc/self/clear_refs") << 5;
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "VmHWM:") continue;
    double kilobytes = 0;
    status >> kilobytes;
    return kilobytes / 1024;
  }
  return 0;
}

#ifdef SLIPSTREAM_OPENCV_PHASE_UNWRAPPING
Image<float> unwrapped_by_opencv(const Image<float>& wrapped) {
  using Unwrapping = cv::phase_unwrapping::HistogramPhaseUnwrapping;
  Unwrapping::Params settings;
  settings.width = wrapped.width();
  settings.height = wrapped.height();
  cv::Mat phase(settings.height, settings.width, CV_32F), valid(phase.size(), CV_8U), result;
  for (int y = 0; y < settings.height; ++y) {
    for (int x = 0; x < settings.width; ++x) {
      valid.at<uchar>(y, x) = std::isnan(wrapped(x, y)) ? 0 : 255;
      phase.at<float>(y, x) = std::isnan(wrapped(x, y)) ? 0 : wrapped(x, y);
    }
  }
  Unwrapping::create(settings)->unwrapPhaseMap(phase, result, valid);
  Image<float> unwrapped(wrapped.size());
  for (int y = 0; y < settings.height; ++y) {
    std::copy_n(result.ptr<float>(y), settings.width, &unwrapped(0, y));
  }
  return unwrapped;
}
#endif

Image<float> unwrapped_by(const std::string& method, const Image<float>& wrapped) {
#ifdef SLIPSTREAM_OPENCV_PHASE_UNWRAPPING
  if (method == "opencv") return unwrapped_by_opencv(wrapped);
#endif
  return unwrap_in_space(wrapped, {}, method).phase;
}

void measure(const std::string& method, const NamedPhase& phase, Size size) {
  const KnownPhase known = phase.make(size);
  const double before = peak_memory(true);
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t busy = std::clock();
  const Image<float> unwrapped = unwrapped_by(method, known.wrapped);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  // CPU time of all threads; other programs affect only the wall-clock time.
  const double worked = static_cast<double>(std::clock() - busy) / CLOCKS_PER_SEC;
  std::printf("%-13s %-9s %9s  right %8.4f %%  %8.3f s  %8.3f s of work  %6.0f MB\n",
              method.c_str(), phase.name.c_str(), text_of(size).c_str(),
              100 * right_share(known, unwrapped), took.count(), worked,
              peak_memory(false) - before);
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
      if (only == "opencv") measure(only, phase, size);
      for (const SpatialUnwrapping& method : spatial_unwrappings()) {
        if (!only.empty() && only != method.name) continue;
        measure(std::string(method.name), phase, size);
      }
    }
  }
}
