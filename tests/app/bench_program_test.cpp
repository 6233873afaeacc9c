// The program's benchmark prints all of its rows. Not in sanitized builds: other tests cover the
// same code there.
#include <string>

#include <gtest/gtest.h>

#include "tests/app/program.h"

namespace slipstream::bench_program_test {

TEST(BenchProgram, TimesEveryRow) {
  const ProgramRun run = run_program({"bench", "--quick", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const std::string name :
       {"general", "closed-form", "mlut", "plut", "mlut+plut", "2+1", "inverse", "form1", "form2",
        "form3", "equations", "traditional", "lut", "simd", "fused", "engine", "fused-corrected",
        "fused-dual", "opencv-hand"}) {
    EXPECT_NE(run.out.find("\"name\": \"" + name + "\""), std::string::npos) << name;
  }
  for (const char* key : {"steps", "width", "height", "threads", "ms", "fps"}) {
    EXPECT_NE(run.out.find("\"" + std::string(key) + "\": "), std::string::npos) << key;
  }
}

TEST(BenchProgram, HoldsAGpuBesideTheFusedPass) {
  const ProgramRun run = run_program({"bench", "--gpu", "--quick"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* words : {"GPU: ", "gpu-cloud", "gpu-dual-depth16", "gpu-multi-resident"}) {
    EXPECT_NE(run.out.find(words), std::string::npos) << words << " in\n" << run.out;
  }
}

}  // namespace slipstream::bench_program_test
