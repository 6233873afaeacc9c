// What a change of the scanner costs: the tables of the fused pass at 640x480.
#include <benchmark/benchmark.h>

#include "slipstream/geometry/ray_table.h"
#include "slipstream/geometry/stripe_geometry.h"
#include "slipstream/simulate/named_scenes.h"

namespace slipstream {
namespace {

void ray_table_640x480(benchmark::State& state) {
  const Lens camera = example_scanner().camera;
  for (auto _ : state) benchmark::DoNotOptimize(ray_table(camera));
}
BENCHMARK(ray_table_640x480)->Unit(benchmark::kMillisecond)->UseRealTime();

void stripe_geometry_with_projector_lens(benchmark::State& state) {
  const Scanner scanner = example_scanner();
  for (auto _ : state) benchmark::DoNotOptimize(stripe_geometry(scanner, Axis::x, 0.02));
}
BENCHMARK(stripe_geometry_with_projector_lens)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace slipstream
