#include <gtest/gtest.h>

#include "paper/reproduction.h"

namespace slipstream::report_test {

const Reproduced& sample() {
  static const Reproduced reproduced{
      {"table", "9.1", "a table", {}},
      {.cells = {{"error, rad", {{"N", 3}, {"gamma", 2.5}}, 0.25, 0.251234, {}}},
       .plots = {},
       .notes = {"A note."}},
      {"plots/figure-9.1.png"}};
  return reproduced;
}

TEST(ReproducedReport, IsASectionWithPicturesRelativeToItsFolder) {
  EXPECT_EQ(markdown_of(sample(), "reports"),
            "## table-9.1: a table\n\n"
            "| quantity | of | published | recomputed | improved |\n"
            "| --- | --- | --- | --- | --- |\n"
            "| error, rad | N = 3, gamma = 2.5 | 0.25 | 0.2512 |  |\n\n"
            "A note.\n\n"
            "![figure-9.1](../plots/figure-9.1.png)\n\n");
}

TEST(ReproducedReport, IsTextWithoutEmptyColumns) {
  const std::string text = text_of(sample());
  for (const char* words : {"table-9.1: a table", "error, rad", "published      0.25", "0.2512",
                            "A note.", "plots/figure-9.1.png"}) {
    EXPECT_NE(text.find(words), std::string::npos) << words << " in\n" << text;
  }
  EXPECT_EQ(text.find("improved"), std::string::npos) << text;
}

}  // namespace slipstream::report_test
