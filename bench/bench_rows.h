#pragma once

#include "bench/timing.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/geometry/scan.h"

namespace slipstream {

/// What the virtual scanner sees of a statue before a wall, 8 bits, with noise and an ambient light
/// that it knows, stripes along x.
Scan bench_scan(const Strategy& strategy, Size camera = {640, 480});

/// Each pixel k x k pixels of a camera of k times the width and height: the same scene and geometry
/// without hours of rendering.
Scan enlarged(const Scan& scan, int k);

/// A statue alone, turned by a degree or not.
Cloud statue_cloud(bool turned);

struct BenchSettings {
  std::vector<int> steps{3, 4, 6};                ///< of the rows of Table 2.2
  std::vector<int> enlargements{1, 2, 4, 8};      ///< of 640x480: 0.3 to 20 megapixels
  std::vector<Size> small{{64, 48}, {160, 120}};  ///< beside a GPU
  int most_threads = 1;
};

/// Every row of `slipstream bench`, ready to run: Table 2.2 for each N, the fused pass alone and
/// as everybody calls it, with a phase correction, for other codings, its sizes on
/// one thread and on all, and OpenCV.
/// What they need is built here; a row keeps alive what it shares with others.
std::vector<BenchRow> bench_rows(const BenchSettings& settings);

/// What the first GPU makes of the smallest and largest pictures, beside the fused pass on all
/// threads: frames in memory to clouds, depths and depths in 16 bits in memory, and what the device
/// takes by itself; and of many smaller ones, one after another and in one submission. Throws
/// WorldError where there is no GPU.
std::vector<BenchRow> gpu_rows(const BenchSettings& settings);

}  // namespace slipstream
