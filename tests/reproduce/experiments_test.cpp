// The dissertation's experiments beside the print: Chapter 1, Tables 2.1 and 2.2, Section 3.3 and
// the surfaces of Section 4.5.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "paper/reproduction.h"

namespace slipstream::experiments_test {

Reproduction run(const char* name) {
  return reproducibles_named({name}).front().run(1);
}

/// Whether a cell is for that f_h.
bool is_of_high(const ReproducedCell& cell, double high) {
  return std::find(cell.parameters.begin(), cell.parameters.end(),
                   std::pair<std::string, double>("f_h", high)) != cell.parameters.end();
}

bool has_note(const Reproduction& result, const char* words) {
  return std::any_of(result.notes.begin(), result.notes.end(), [&](const std::string& note) {
    return note.find(words) != std::string::npos;
  });
}

TEST(Experiments, Table21CountsThePrintedOperations) {
  const Reproduction result = run("table-2.1");
  ASSERT_EQ(result.cells.size(), 9U);
  for (const ReproducedCell& cell : result.cells) {
    EXPECT_EQ(cell.recomputed, cell.published) << cell.quantity;
  }
}

TEST(Experiments, Table22HasThePrintedRowsAndSaysWhyTheGainIsAnother) {
  const Reproduction result = run("table-2.2");
  std::map<std::string, int> rows;
  for (const ReproducedCell& cell : result.cells) {
    ++rows[cell.quantity];
    ASSERT_TRUE(cell.published && cell.recomputed) << cell.quantity;
    EXPECT_GT(*cell.recomputed, 0) << cell.quantity;
    const bool is_by_tables = cell.quantity.find("LUT, and then") != std::string::npos ||
                              cell.quantity.find("times as fast") != std::string::npos;
    EXPECT_EQ(cell.improved.has_value(), is_by_tables) << cell.quantity;
  }
  EXPECT_EQ(rows.size(), 13U);
  for (const auto& [row, cells] : rows) {
    EXPECT_EQ(cells, row.find("2+1") == std::string::npos ? 3 : 1) << row;
  }
  EXPECT_TRUE(has_note(result, "faster at arctangents"));
  EXPECT_TRUE(has_note(result, "For N = 6"));
}

TEST(Experiments, Table34AgreesWithThePrintExceptAtTheHighestFrequency) {
  const Reproduction result = run("table-3.4");
  ASSERT_EQ(result.cells.size(), 9U);
  for (const ReproducedCell& cell : result.cells) {
    EXPECT_NEAR(*cell.recomputed, *cell.published, is_of_high(cell, 8) ? 2.1 : 0.35);
    EXPECT_GT(*cell.improved, 99.9);
  }
  EXPECT_TRUE(has_note(result, "at f_h = 8 the print is up to 2 points lower"));
}

TEST(Experiments, Table36AgreesWithThePrintExceptAtTheHighestFrequency) {
  const Reproduction result = run("table-3.6");
  ASSERT_EQ(result.cells.size(), 9U);
  for (const ReproducedCell& cell : result.cells) {
    EXPECT_NEAR(*cell.recomputed, *cell.published, is_of_high(cell, 12) ? 0.75 : 0.5);
    EXPECT_GT(*cell.improved, 99.9);
  }
  EXPECT_TRUE(has_note(result, "0.7 % more at f_h = 12"));
}

TEST(Experiments, Section33MeasuresTheNoiseAndThreePatternPcmp) {
  const Reproduction result = run("section-3.3");
  ASSERT_EQ(result.cells.size(), 9U);
  // The larger ones have their reason in a note.
  constexpr std::array tolerances{0.02, 0.1, 0.03, 0.4, 0.4, 0.4, 2.3, 0.3, 0.11};
  for (std::size_t i = 0; i < tolerances.size(); ++i) {
    const ReproducedCell& cell = result.cells[i];
    EXPECT_NEAR(*cell.recomputed, *cell.published, tolerances.at(i)) << cell.quantity;
  }
  for (const char* words : {"gamma does not explain", "2.9 grey levels", "no room for gamma"}) {
    EXPECT_TRUE(has_note(result, words)) << words;
  }
}

TEST(Experiments, Figure312HasThePrintedSpread) {
  const Reproduction result = run("figure-3.12");
  ASSERT_EQ(result.cells.size(), 4U);
  for (const ReproducedCell& cell : result.cells) {
    EXPECT_NEAR(*cell.recomputed / *cell.published, 1, 0.05) << cell.quantity;
  }
  EXPECT_EQ(result.plots.size(), 1U);
}

TEST(Experiments, FiguresOfNoiseOnABoardAgreeWithThePrint) {
  for (const char* const name : {"figure-3.13", "figure-3.14", "figure-3.15"}) {
    const Reproduction result = run(name);
    EXPECT_EQ(result.plots.size(), 2U) << name;
    ASSERT_EQ(result.cells.size(), 1U) << name;
    EXPECT_NEAR(*result.cells[0].recomputed / *result.cells[0].published, 1, 0.04) << name;
  }
}

TEST(Experiments, FiguresOfABoardUnderPcmpAreAsGoodAsThePrintOrBetter) {
  for (const char* const name : {"figure-3.16", "figure-3.19", "figure-3.22"}) {
    const Reproduction result = run(name);
    EXPECT_EQ(result.plots.size(), 2U) << name;
    EXPECT_GT(*result.cells.at(0).recomputed, *result.cells[0].published - 0.5) << name;
  }
  for (const char* const name : {"figure-3.17", "figure-3.20", "figure-3.23"}) {
    const Reproduction result = run(name);
    ASSERT_EQ(result.cells.size(), 2U) << name;
    EXPECT_NEAR(*result.cells[0].recomputed / *result.cells[0].published, 1, 0.1) << name;
    EXPECT_LT(*result.cells[1].recomputed, 1.1 * *result.cells[1].published) << name;
  }
}

TEST(Experiments, FiguresOfTheAngelHaveLessErrorByPcmp) {
  const std::array<std::pair<const char*, std::size_t>, 3> scans{
      {{"figure-3.18", 2}, {"figure-3.21", 10}, {"figure-3.24", 10}}};
  for (const auto& [name, count] : scans) {
    const Reproduction result = run(name);
    EXPECT_EQ(result.plots.size(), 1U) << name;
    ASSERT_EQ(result.cells.size(), count) << name;
    for (std::size_t i = 1; i < count; ++i) {
      EXPECT_LT(*result.cells[i].recomputed, 0.8 * *result.cells[0].recomputed) << name << i;
    }
  }
}

TEST(Experiments, FiguresOfTheHandShowManyPointsCloseToIt) {
  for (const char* const name : {"figure-2.3", "figure-2.4"}) {
    const Reproduction result = run(name);
    ASSERT_EQ(result.cells.size(), 6U) << name;
    for (std::size_t i = 0; i < 6; i += 2) {
      EXPECT_GT(*result.cells[i].recomputed, 10000) << name << i;
      EXPECT_LT(*result.cells[i + 1].recomputed, 5) << name << i;
    }
  }
}

TEST(Experiments, FiguresOfGammaHaveNumbersOfTheirOwn) {
  const Reproduction fit = run("figure-4.14");
  EXPECT_EQ(fit.plots.size(), 2U);
  EXPECT_NEAR(*fit.cells.at(0).recomputed, 2.21, 0.02);
  EXPECT_NEAR(*fit.cells.at(1).recomputed, 1.1e-3, 3e-4);
  EXPECT_EQ(run("figure-4.12").plots.size(), 1U);
  for (const char* const name : {"figure-4.16", "figure-4.17"}) {
    const Reproduction result = run(name);
    EXPECT_EQ(result.plots.size(), 3U) << name;
    EXPECT_GT(*result.cells.at(2).recomputed, 30) << name;
  }
}

TEST(Experiments, FiguresOfTheIntroductionAgreeWithTheirEquation) {
  const Reproduction noise = run("figure-1.27");
  ASSERT_EQ(noise.cells.size(), 20U);
  for (const ReproducedCell& cell : noise.cells) {
    EXPECT_NEAR(*cell.recomputed / *cell.published, 1, 0.05) << cell.quantity;
  }
  const Reproduction unwrapping = run("figure-1.28");
  EXPECT_EQ(unwrapping.plots.size(), 3U);
  EXPECT_GT(*unwrapping.cells.at(0).recomputed, 99.9);
}

TEST(Experiments, FiguresOfHarmonicsAgreeWithTheModel) {
  EXPECT_EQ(run("figure-1.43").plots.size(), 2U);
  EXPECT_EQ(run("figure-1.45").plots.size(), 3U);
  const Reproduction magnitudes = run("figure-1.44");
  EXPECT_EQ(magnitudes.plots.size(), 3U);
  ASSERT_EQ(magnitudes.cells.size(), 2U);
  for (const ReproducedCell& cell : magnitudes.cells) {
    EXPECT_NEAR(*cell.recomputed, *cell.published, 0.003);
  }
}

TEST(Experiments, Figure21ShowsEachTable) {
  const Reproduction result = run("figure-2.1");
  EXPECT_EQ(result.plots.size(), 6U);
  const double ellipse = 100 * std::acos(-1.0) * std::sqrt(3) * 9 / 96;
  EXPECT_NEAR(*result.cells[0].recomputed, ellipse, 0.3);
  EXPECT_NEAR(*result.cells[1].recomputed, 25 * std::acos(-1.0), 0.3);
  EXPECT_NEAR(*result.cells[2].recomputed, ellipse, 0.3);
}

TEST(Experiments, SurfacesWithoutCalibrationArePicturesWithLessError) {
  // The relief of the fish has edges, where pixels see two surfaces.
  for (const auto& [name, times] : {std::pair("figure-4.19", 30), std::pair("figure-4.26", 20)}) {
    const Reproduction result = run(name);
    EXPECT_EQ(result.plots.size(), 3U) << name;
    ASSERT_EQ(result.cells.size(), 2U) << name;
    EXPECT_LT(*result.cells[1].recomputed, *result.cells[0].recomputed / times) << name;
  }
}

}  // namespace slipstream::experiments_test
