// Reconstructs a scan folder in one call: folder_to_cloud SCAN CLOUD.ply
#include <cstdio>

#include "slipstream/cloud_file.h"
#include "slipstream/error.h"
#include "slipstream/scan_files.h"
#include "slipstream/scan_job.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    const slipstream::ScanResult result = slipstream::reconstruct(slipstream::load_scan(argv[1]));
    slipstream::write_cloud(argv[2], result.cloud);
    std::printf("%zu points\n", result.counts[0]);
  } catch (const slipstream::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
