// Every fuzz target on its seeds, on what once went wrong and on a fixed number of mutated inputs:
// each is taken or refused in one line.
#include <chrono>
#include <cstdlib>

#include <gtest/gtest.h>

#include "io/file.h"
#include "tests/fuzz/target.h"

namespace slipstream::fuzz_test {
namespace fs = std::filesystem;

/// 2000, or as many as SLIPSTREAM_FUZZ_INPUTS says; others by SLIPSTREAM_FUZZ_SEED.
long inputs_wanted() {
  const char* asked = std::getenv("SLIPSTREAM_FUZZ_INPUTS");
  return asked == nullptr ? 2000 : std::atol(asked);
}

unsigned seed_wanted() {
  const char* asked = std::getenv("SLIPSTREAM_FUZZ_SEED");
  return asked == nullptr ? 2010U : static_cast<unsigned>(std::atol(asked));
}

/// False, and the input is kept for a look, where something else came than a refusal.
bool is_taken_or_refused(const FuzzTarget& target, const Bytes& input) {
  try {
    run_fuzz_target(target, input);
    return true;
  } catch (const std::exception& exception) {
    const fs::path kept = fs::temp_directory_path() / ("finding-" + target.name);
    write_file(kept, input);
    ADD_FAILURE() << target.name << ": " << exception.what() << "; the input is " << kept;
    return false;
  }
}

class Fuzz : public testing::TestWithParam<std::string> {
 protected:
  [[nodiscard]] static const FuzzTarget& target() {
    return *std::find_if(fuzz_targets().begin(), fuzz_targets().end(),
                         [](const FuzzTarget& each) { return each.name == GetParam(); });
  }
};

TEST_P(Fuzz, TakesOrRefuses) {
  const std::vector<Bytes> seeds = target().seeds();
  for (const Bytes& seed : seeds) {
    EXPECT_NO_THROW(target().run(seed));
    EXPECT_TRUE(is_taken_or_refused(target(), seed));
  }
  const fs::path kept = fs::path(SLIPSTREAM_SOURCE_FOLDER) / "tests/fuzz/regressions" / GetParam();
  if (fs::exists(kept)) {
    for (const auto& file : fs::directory_iterator(kept)) {
      EXPECT_TRUE(is_taken_or_refused(target(), read_file(file.path()))) << file.path();
    }
  }
  std::mt19937 random(seed_wanted());
  for (long i = 0; i < inputs_wanted() / target().cost; ++i) {
    const Bytes& seed = seeds[random() % seeds.size()];
    ASSERT_TRUE(is_taken_or_refused(target(), mutated(seed, random)));
  }
}

TEST(FuzzTarget, CostsNoMoreThanInProportionToItsInput) {
  const auto square = [](std::span<const std::uint8_t> input) {
    const std::vector<std::uint8_t> memory(input.size() * input.size());
    if (memory.capacity() < input.size()) throw std::logic_error("no memory");
  };
  const FuzzTarget target{
      .name = "square", .run = square, .bytes_each = 100, .bytes_besides = 5000};

  EXPECT_NO_THROW(run_fuzz_target(target, Bytes(100)));
  EXPECT_THROW(run_fuzz_target(target, Bytes(1000)), std::logic_error);
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const FuzzTarget& target : fuzz_targets()) all.push_back(target.name);
  return all;
}

INSTANTIATE_TEST_SUITE_P(Target, Fuzz, testing::ValuesIn(names()), [](const auto& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

}  // namespace slipstream::fuzz_test
