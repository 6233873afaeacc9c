#include "paper/reproduction.h"

#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "slipstream/error.h"

namespace slipstream::reproduction_test {

TEST(Reproduction, ReproduciblesHaveNamesOfTheirOwn) {
  std::set<std::string> names;
  for (const Reproducible& item : reproducibles()) {
    EXPECT_TRUE(names.insert(item.name()).second) << item.name();
  }
  EXPECT_TRUE(names.contains("table-4.1"));
  EXPECT_TRUE(names.contains("section-4.5"));
  for (const char* const name :
       {"figure-1.27", "figure-1.28", "figure-2.3",  "figure-2.4", "figure-1.43", "figure-1.44",
        "figure-1.45", "figure-2.1",  "table-2.1",   "table-2.2",  "table-3.1",   "table-3.2",
        "table-3.3",   "table-3.4",   "table-3.5",   "table-3.6",  "table-3.7",   "figure-3.1",
        "figure-3.2",  "figure-3.3",  "figure-3.5",  "figure-3.7", "figure-3.8",  "figure-3.10",
        "figure-3.11", "figure-3.12", "section-3.3", "table-4.1"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
  for (int figure = 10; figure <= 24; ++figure) {
    EXPECT_TRUE(names.contains("figure-3." + std::to_string(figure)));
  }
  for (int figure = 1; figure <= 26; ++figure) {
    EXPECT_TRUE(names.contains("figure-4." + std::to_string(figure)));
  }
}

TEST(Reproduction, ReproduciblesAreChosenByName) {
  EXPECT_EQ(reproducibles_named({}).size(), reproducibles().size());
  EXPECT_EQ(reproducibles_named({"all"}).size(), reproducibles().size());
  EXPECT_EQ(reproducibles_named({"figure-4.1"}).size(), 1U);
  EXPECT_EQ(reproducibles_named({"figure-4."}).size(), 26U);
  EXPECT_THROW((void)reproducibles_named({"figure-4.99"}), Error);
}

TEST(Reproductions, OfChapter3AgreeWithThePrint) {
  for (const Reproducible& item : reproducibles_named({"figure-3."})) {
    if (item.id >= std::string_view("3.12") && item.id.size() == 4) continue;  // experiments
    const Reproduction result = item.run(1);
    EXPECT_FALSE(result.plots.empty()) << item.name();
    for (const ReproducedCell& cell : result.cells) {
      ASSERT_TRUE(cell.recomputed && std::isfinite(*cell.recomputed)) << cell.quantity;
      // At alpha of 0.05 and less the noise is not small any more.
      const bool dark =
          cell.parameters.front().first == "alpha" && cell.parameters.front().second < 0.08;
      if (!cell.published || dark) continue;
      EXPECT_NEAR(*cell.recomputed / *cell.published, 1, 0.08) << item.name() << cell.quantity;
    }
  }
}

TEST(Reproductions, OfTheModelAgreeWithThePrintToTwoDigits) {
  std::vector<std::string> names{"table-4.1"};
  for (int figure = 1; figure <= 10; ++figure) names.push_back(fmt::format("figure-4.{}", figure));
  for (const Reproducible& item : reproducibles_named(names)) {
    const Reproduction result = item.run(1);
    EXPECT_FALSE(result.cells.empty() && result.plots.empty()) << item.name();
    for (const ReproducedCell& cell : result.cells) {
      ASSERT_TRUE(cell.recomputed && std::isfinite(*cell.recomputed)) << cell.quantity;
      if (!cell.published) continue;
      EXPECT_NEAR(*cell.recomputed / *cell.published, 1, 0.015) << item.name() << cell.quantity;
    }
  }
}

}  // namespace slipstream::reproduction_test
