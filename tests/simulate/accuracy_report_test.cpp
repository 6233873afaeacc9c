#include "simulate/accuracy_report.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "tests/io/temporary_folder.h"
#include "tests/simulate/cast_cloud.h"

namespace slipstream::accuracy_report_test {

TEST(AccuracyReport, IsAPageBesideItsPictures) {
  const Artefacts artefacts{.diameters = {40, 40},
                            .distance = 120,
                            .distance_uncertainty = 0.002,
                            .spheres = {"bar 1"},
                            .diagonal = 400,
                            .temperature = 20.5,
                            .notes = {"ball bar no. 7"}};
  const Scene scene{sphere_at({-60, 0, 600}, 20), sphere_at({60, 0, 600}, 20)};
  const Accuracy found =
      measure_accuracy(artefacts, [&](const std::string&) { return cast_cloud(scene); });

  std::vector<AccuracyFigure> figures = accuracy_figures(found);
  set_limits(figures, {{"probing_size", 0.5}});
  const TemporaryFolder folder;
  write_accuracy_report(
      folder.path() / "report",
      {artefacts, found, figures, verdict_of(found, figures, false), {{"command", "a < b"}}});

  const std::string text = read_text(folder.path() / "report/report.html");
  for (const char* part :
       {"Passed: the figure is within its limit.", "<td>a &lt; b</td>", "<td>ball bar no. 7</td>",
        "120 mm, expanded uncertainty 0.002 mm (k = 2)", "40 and 40 mm, uncertainty not stated",
        "20.5 degrees Celsius", "sphere-spacing error", "<td>pass</td>", "<td>bar 1</td>",
        "<thead>", "Name and signature",
        "alt=\"deviations: bar 1\" src=\"data:image/png;base64,iVBOR"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
  for (const char* picture : {"sphere.png", "front.png", "top.png"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "report" / picture)) << picture;
  }
}

}  // namespace slipstream::accuracy_report_test
