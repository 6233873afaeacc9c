#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/calibration_board.h"
#include "tests/io/expect_error.h"

namespace slipstream::ruler_test {

const CalibrationBoard chessboard{.columns = 13, .rows = 9, .spacing = 10};

std::string advice(const CalibrationBoard& board, const MeasuredPrint& measured) {
  const std::vector<Finding> findings = findings_of_ruler(board, measured);
  return findings.size() == 1 ? remedies_of(findings[0]) : "";
}

TEST(Ruler, SaysWhichSpacingToGive) {
  EXPECT_EQ(advice(chessboard, {121.9, 81.3}), "use `spacing 10.16`");
  EXPECT_EQ(advice(chessboard, {121.9, 80.3}), "use `spacing 10.16x10.04`");
  EXPECT_EQ(advice(chessboard, {80, 120}), "use `measured 120x80`");
  EXPECT_TRUE(findings_of_ruler(chessboard, {120.2, 79.8}).empty()) << "as well as a ruler reads";
  CalibrationBoard stretched = chessboard;
  stretched.row_spacing = 10.04;
  stretched.spacing = 10.16;
  EXPECT_TRUE(findings_of_ruler(stretched, {121.9, 80.3}).empty());
  EXPECT_DOUBLE_EQ(printed_places(stretched).back().y(), 8 * 10.04);
}

TEST(Ruler, MeasuresCirclesAlongARowAndFromRowToRow) {
  const CalibrationBoard circles{
      .kind = BoardKind::circles, .columns = 5, .rows = 8, .spacing = 16};
  EXPECT_TRUE(findings_of_ruler(circles, {8 * 16, 7 * 16}).empty());
  CalibrationBoard odd = circles;
  odd.rows = 9;
  EXPECT_TRUE(findings_of_ruler(odd, {8 * 16, 8 * 16}).empty());
  EXPECT_EQ(advice(circles, {8 * 16.5, 7 * 16.5}), "use `spacing 16.5`");
}

TEST(Ruler, TellsHowMuchTooLongInPercentAndTheLimit) {
  const std::vector<Finding> findings = findings_of_ruler(chessboard, {121.2, 80});
  ASSERT_EQ(findings.size(), 1U);

  const Evidence& rows = findings[0].evidence[0];
  EXPECT_EQ(rows.unit, "%");
  EXPECT_NEAR(rows.value, 1, 1e-9);
  EXPECT_GT(rows.value, rows.limit.value());

  const Evidence& columns = findings[0].evidence[1];
  EXPECT_LT(columns.value, columns.limit.value());
}

TEST(Ruler, LengthsThatCannotBeAreAnError) {
  expect_error([] { (void)findings_of_ruler(chessboard, {0, 80}); }, {"0x80", "above 0"});
}

}  // namespace slipstream::ruler_test
