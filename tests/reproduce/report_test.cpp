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

TEST(Report, ReproducedReportIsASectionWithPicturesRelativeToItsFolder) {
  Page page("reports");
  page.paragraph("a < b & \"c\"");
  add_to(page, sample(), std::filesystem::absolute("reports"));
  const std::string text = page.text();
  for (const char* words :
       {"<p>a &lt; b &amp; &quot;c&quot;</p>", "<h2>table-9.1: a table</h2>",
        "<tr><td>error, rad</td><td>N = 3, gamma = 2.5</td><td>0.25",
        "<td>0.2512</td><td></td></tr>", "<p>A note.</p>", "src=\"../plots/figure-9.1.png\""}) {
    EXPECT_NE(text.find(words), std::string::npos) << words << " in\n" << text;
  }
}

TEST(Report, ReproducedReportIsTextWithoutEmptyColumns) {
  const std::string text = text_of(sample());
  for (const char* words : {"table-9.1: a table", "error, rad", "published      0.25", "0.2512",
                            "A note.", "plots/figure-9.1.png"}) {
    EXPECT_NE(text.find(words), std::string::npos) << words << " in\n" << text;
  }
  EXPECT_EQ(text.find("improved"), std::string::npos) << text;
}

}  // namespace slipstream::report_test
