#pragma once

#include <vector>

#include "bench/timing.h"
#include "slipstream/cloud.h"
#include "slipstream/scan.h"

namespace slipstream {

/// Simulated scan of a statue in front of a wall: 8 bits, noise, known ambient light, axis x.
Scan bench_scan(const Strategy& strategy, Size camera = {640, 480});

/// The same seen by a second camera, too: in `further_cameras`.
Scan bench_pair(const Strategy& strategy);

/// Replaces each pixel by k x k pixels of a camera with k times the width and height: the same
/// scene and geometry without hours of rendering.
Scan enlarged(const Scan& scan, int k);

/// The statue alone, turned by a degree if `turned`.
Cloud statue_cloud(bool turned);

struct BenchSettings {
  std::vector<int> steps{3, 4, 6};                ///< N, for the rows of Table 2.2
  std::vector<int> enlargements{1, 2, 4, 8};      ///< of 640x480: 0.3 to 20 megapixels
  std::vector<Size> small{{64, 48}, {160, 120}};  ///< for comparison with a GPU
  int most_threads = 1;
};

/// All rows of `slipstream bench`, ready to run: Table 2.2 for each N, the fused pass alone,
/// through the public call and with a phase correction, other codings, its sizes on one thread and
/// on all, and OpenCV. Inputs are built here and shared by the rows.
std::vector<BenchRow> bench_rows(const BenchSettings& settings);

/// The smallest and largest images on the first GPU, and in the fused pass on all threads: frames
/// in memory to clouds, depths and 16-bit depths in memory, and the time of the device alone; also
/// many small scans, one after another and in one submission. Throws WorldError without a GPU.
std::vector<BenchRow> gpu_rows(const BenchSettings& settings);

}  // namespace slipstream
