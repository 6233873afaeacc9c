#include <algorithm>
#include <cstddef>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/one_frame.h"

namespace slipstream::symbol_grid_test {

TEST(Demodulation, ColouredStripesAreKnownByFewTransitions) {
  for (int stripes = 8; stripes <= 256; ++stripes) {
    const SymbolGrid grid = coloured_stripes(stripes);
    ASSERT_EQ(grid.columns, stripes);
    ASSERT_EQ(grid.rows(), 1);
    std::string rises;  // of each channel
    for (std::size_t i = 0; i < grid.symbols.size(); ++i) {
      ASSERT_TRUE(grid.symbols[i] >= 1 && grid.symbols[i] <= 6);
      if (i == 0) continue;
      ASSERT_NE(grid.symbols[i], grid.symbols[i - 1]);
      ASSERT_NE(grid.symbols[i] & grid.symbols[i - 1], 0) << "a channel is lit in both";
      for (unsigned c = 0; c < 3; ++c) {
        rises += "-0+"[1 + ((grid.symbols[i] >> c) & 1) - ((grid.symbols[i - 1] >> c) & 1)];
      }
    }
    std::set<std::string> windows;
    for (std::size_t at = 0; at + 3 * stripe_window <= rises.size(); at += 3) {
      EXPECT_TRUE(windows.insert(rises.substr(at, 3 * stripe_window)).second);
    }
  }
}

TEST(Demodulation, SymbolArrayIsKnownBySmallSquares) {
  for (const auto& [columns, rows] : {std::pair{8, 8}, {8, 512}, {512, 8}, {40, 25}, {64, 64}}) {
    const SymbolGrid grid = symbol_array(columns, rows);
    ASSERT_EQ(grid.columns, columns);
    ASSERT_EQ(grid.rows(), rows);
    ASSERT_LT(*std::max_element(grid.symbols.begin(), grid.symbols.end()), 3);
    std::set<std::string> squares;
    for (int row = 0; row + symbol_window <= rows; ++row) {
      for (int column = 0; column + symbol_window <= columns; ++column) {
        std::string square;
        for (int i = 0; i < symbol_window * symbol_window; ++i) {
          const int at = (row + i / symbol_window) * columns + column + i % symbol_window;
          square += static_cast<char>(grid.symbols[static_cast<std::size_t>(at)]);
        }
        EXPECT_TRUE(squares.insert(square).second) << column << " " << row;
      }
    }
  }
}

TEST(Demodulation, SymbolGridRefusesWhatCannotBeKnownOrSeen) {
  EXPECT_THROW(coloured_stripes(7), Error);
  EXPECT_THROW(coloured_stripes(257), Error);
  EXPECT_THROW(symbol_array(7, 40), Error);
  EXPECT_THROW(symbol_array(40, -1), Error);
  EXPECT_THROW(symbol_array(1000000, 1000000), Error);
}

TEST(Demodulation, SymbolGridShowsLevelsEverywhere) {
  for (const SymbolGrid& grid : {coloured_stripes(20), symbol_array(12, 9)}) {
    for (const double y : {0.0, 0.3, 1.0, -0.2, 1.2}) {
      for (const double across : {0.0, 0.7, 1.0}) {
        for (int n = 0; n < 3; ++n) {
          const double level = grid_intensity(grid, n, y, across);
          EXPECT_TRUE(level >= 0 && level <= 1) << level;
        }
      }
    }
  }
}

}  // namespace slipstream::symbol_grid_test
