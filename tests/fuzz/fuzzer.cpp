// The fuzz targets under libFuzzer: SLIPSTREAM_FUZZ_TARGET names one; SLIPSTREAM_FUZZ_SEEDS a
// folder that its seeds are written to, nothing else is done then.
#include <cstdio>
#include <cstdlib>

#include "io/file.h"
#include "tests/fuzz/target.h"

namespace {

const slipstream::FuzzTarget* chosen = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* wanted = std::getenv("SLIPSTREAM_FUZZ_TARGET");
  for (const auto& target : slipstream::fuzz_targets()) {
    if (wanted != nullptr && target.name == wanted) chosen = &target;
  }
  if (chosen == nullptr) {
    for (const auto& target : slipstream::fuzz_targets()) std::puts(target.name.c_str());
    std::exit(wanted == nullptr ? 0 : 2);
  }
  if (const char* folder = std::getenv("SLIPSTREAM_FUZZ_SEEDS")) {
    const auto seeds = chosen->seeds();
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      slipstream::write_file(std::filesystem::path(folder) / ("seed" + std::to_string(i)),
                             seeds[i]);
    }
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  slipstream::run_fuzz_target(*chosen, {data, size});
  return 0;
}
