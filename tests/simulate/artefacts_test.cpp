#include "simulate/artefacts.h"

#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "slipstream/error.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::artefacts_test {

class ArtefactsFile : public TemporaryFolder {
 public:
  [[nodiscard]] Artefacts read(const std::string& text) const {
    std::ofstream(path() / "a.yaml") << text;
    return read_artefacts(path() / "a.yaml");
  }
  [[nodiscard]] std::string beside(const char* name) const { return path() / name; }
};

TEST(Artefacts, AreReadWithPathsRelativeToTheFile) {
  const ArtefactsFile file;
  const Artefacts read = file.read(
      "diameters: [40.002, 40.001]  # mm\ndistance: 100.005\nspheres: [bar1, /data/bar2]\n"
      "planes: plane1\nrepeated: [a, b]\ndiagonal: 380\ndiameter-uncertainty: 0.0006\n"
      "temperature: 20.4\nnotes: [camera 40, lens 12 mm]\n");
  EXPECT_EQ(read.diameters, (std::vector<double>{40.002, 40.001}));
  EXPECT_EQ(read.distance, 100.005);
  EXPECT_EQ(read.spheres, (std::vector<std::string>{file.beside("bar1"), "/data/bar2"}));
  EXPECT_EQ(read.planes, std::vector<std::string>{file.beside("plane1")});
  EXPECT_EQ(read.repeated, (std::vector<std::string>{file.beside("a"), file.beside("b")}));
  EXPECT_EQ(read.diagonal, 380);
  EXPECT_EQ(read.diameter_uncertainty, 0.0006);
  EXPECT_EQ(read.distance_uncertainty, std::nullopt);
  EXPECT_EQ(read.temperature, 20.4);
  EXPECT_EQ(read.notes, (std::vector<std::string>{"camera 40", "lens 12 mm"}));
}

TEST(Artefacts, AreRefusedInOneLineWhereTheyAreNone) {
  const ArtefactsFile file;
  const auto expect_refused = [&](const std::string& text,
                                  std::initializer_list<std::string> parts) {
    SCOPED_TRACE(text);
    expect_error([&] { (void)file.read(text); }, parts);
  };
  expect_refused("", {"a.yaml"});
  expect_refused("{}", {"a.yaml", "no scans"});
  expect_refused("plane: [p]", {"line 1", "plane", "did you mean planes?"});
  expect_refused("planes: [p]\ndiagonal: -1", {"line 2", "-1", "expected a length"});
  expect_refused("planes: [p]\ndiagonal: nan", {"line 2", "nan", "expected a length"});
  expect_refused("planes: [p]\ndiagonal: 4x", {"4x"});
  expect_refused("planes: [p]\ndiagonal: [3, 4]", {"line 2", "one length"});
  expect_refused("planes: [p]\ntemperature: warm", {"line 2", "expected a temperature"});
  expect_refused("diameters: 40", {"scans of spheres"});
  expect_refused("spheres: [s]", {"diameters"});
  expect_refused("diameters: [40, 40]\nspheres: [s]", {"distance"});
  expect_refused("diameters: 40\ndistance: 9\nspheres: [s]", {"distance"});
  expect_refused("diameters: [1, 2, 3]\nspheres: [s]", {"one or two"});
  expect_refused("repeated: [s]", {"two scans"});
}

RC_GTEST_PROP(Artefacts, AreReadOrRefusedOfAnyText, ()) {
  const std::vector<std::string> words{"diameters", "distance", "spheres", "planes", "repeated",
                                       "diagonal",  ": ",       "\n",      "  ",     "- ",
                                       "[",         "]",        "{",       "}",      ", ",
                                       "40",        "-1",       "1e9",     "'",      "\xff"};
  const auto text = *rc::gen::container<std::vector<std::string>>(rc::gen::elementOf(words));
  const ArtefactsFile file;
  std::string joined;
  for (const std::string& word : text) joined += word;
  try {
    const Artefacts read = file.read(joined);
    RC_ASSERT(read.diameters.size() <= 2U);
    for (const double diameter : read.diameters) RC_ASSERT(diameter > 0);
    RC_ASSERT(!read.spheres.empty() || !read.planes.empty() || read.repeated.size() > 1);
  } catch (const Error& error) {
    RC_ASSERT(std::string(error.what()).starts_with(file.beside("a.yaml")));
    RC_ASSERT(std::string(error.what()).find('\n') == std::string::npos);
  }
}

}  // namespace slipstream::artefacts_test
