// Every (U, V) that 8-bit frames reach: tables and closed forms against the equations in double.
#include "slipstream/decode/phase_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"

namespace slipstream::phase_tables_test {

constexpr int full_scale = 255;

bool is_grey_level(int value) {
  return value >= 0 && value <= full_scale;
}

/// Two grey levels whose difference is that.
std::optional<std::array<int, 2>> levels_apart(int difference) {
  if (std::abs(difference) > full_scale) return std::nullopt;
  return std::array{std::max(difference, 0), std::max(-difference, 0)};
}

/// Some intensities that give (U, V), or nothing where none do.
std::optional<std::vector<double>> intensities_for(int steps, int U, int V) {
  const bool same_parity = (U + V) % 2 == 0;
  if (steps == 4) {
    const auto a = levels_apart(U), b = levels_apart(V);
    return std::vector<double>{double((*a)[0]), double((*b)[0]), double((*a)[1]), double((*b)[1])};
  }
  if (!same_parity) return std::nullopt;
  const int half = (U + V) / 2;
  if (steps == 3) {
    // I_1 = V + I_2 and I_0 = (U + V) / 2 + I_2, with the least I_2 that keeps both from below 0.
    const int I_2 = std::max({0, -V, -half});
    if (!is_grey_level(I_2) || !is_grey_level(I_2 + V) || !is_grey_level(I_2 + half)) return {};
    return std::vector<double>{double(half + I_2), double(V + I_2), double(I_2)};
  }
  // With a = I_1 - I_4, b = I_2 - I_5, c = I_0 - I_3: V = a + b, U = 2 c + a - b.
  const int a =
      std::clamp(half, std::max(-full_scale, V - full_scale), std::min(full_scale, V + full_scale));
  const auto A = levels_apart(a), B = levels_apart(V - a), C = levels_apart(half - a);
  if (!A || !B || !C) return std::nullopt;
  return std::vector<double>{double((*C)[0]), double((*A)[0]), double((*B)[0]),
                             double((*C)[1]), double((*A)[1]), double((*B)[1])};
}

class PhaseTablesOf : public testing::TestWithParam<int> {};

TEST_P(PhaseTablesOf, EqualTheEquationsAtEveryReachableIndex) {
  const int N = GetParam();
  const PhaseTables tables(N);
  const PhaseEquations equations(N);
  long reachable = 0;
  double worst_modulation = 0, worst_phase = 0;
  for (int V = -tables.largest_V(); V <= tables.largest_V(); ++V) {
    for (int U = -tables.largest_U(); U <= tables.largest_U(); ++U) {
      const auto I = intensities_for(N, U, V);
      if (!I) continue;
      ++reachable;
      const auto index = table_index<int>(tables.form(), std::span<const double>(*I));
      ASSERT_EQ(index.U, U);
      ASSERT_EQ(index.V, V);
      const PhaseSample exact = equations(*I);
      worst_modulation = std::max(worst_modulation, std::abs(tables.mlut(U, V) - exact.modulation));
      worst_phase = std::max(worst_phase, std::abs(tables.plut(U, V) - exact.wrapped_phase));
    }
  }
  EXPECT_LE(worst_modulation, 1e-12);
  EXPECT_LE(worst_phase, 1e-12);
  RecordProperty("reachable", std::to_string(reachable));
  // N = 4 reaches all of its square; 3 and 6 reach a hexagon of 3 n (n + 1) + 1 indices, n = 255
  // and 510.
  const long table = (2L * tables.largest_U() + 1) * (2L * tables.largest_V() + 1);
  EXPECT_EQ(reachable, N == 4 ? table : N == 3 ? 195841 : 781831);
}

INSTANTIATE_TEST_SUITE_P(N, PhaseTablesOf, testing::Values(3, 4, 6));

TEST(PhaseTables, RefuseOtherN) {
  EXPECT_THROW(PhaseTables(5), Error);
  EXPECT_EQ(closed_form(8), nullptr);
}

}  // namespace slipstream::phase_tables_test
