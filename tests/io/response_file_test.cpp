#include "slipstream/io/response_file.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/opencv_storage.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/named_scenes.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream {
namespace {
namespace fs = std::filesystem;

class ResponseFile : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] fs::path file(const std::string& name) const {
    return folder_.path() / (name + GetParam());
  }
  [[nodiscard]] std::string text_of(const std::string& name) const {
    const auto bytes = read_file(file(name));
    return {bytes.begin(), bytes.end()};
  }

 private:
  TemporaryFolder folder_;
};

TEST_P(ResponseFile, KeepsEveryOtherEntry) {
  write_scanner(file("scanner"), example_scanner());
  EXPECT_FALSE(read_response(file("scanner")));
  const std::string with_more =
      with_entries(text_of("scanner"),
                   {{"ambient", {1, 1, {7}}}, {"vignette", {2, 2, {1, 2, 3, 4}}}}, "scanner");
  write_file(file("scanner"), with_more);

  write_response(file("scanner"), file("scanner"), PowerLaw{2.21}, 2.21, 0.001);
  EXPECT_EQ(std::get<PowerLaw>(read_response(file("scanner")).value()).gamma, 2.21);
  const auto entries = read_opencv_storage(file("scanner"));
  EXPECT_EQ(entries.at("ambient").numbers, std::vector<double>{7});
  EXPECT_EQ(entries.at("vignette").numbers, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(read_scanner(file("scanner")).translation, example_scanner().translation);

  // Written again it stands there once.
  write_response(file("scanner"), file("copy"), PowerLaw{1.8}, 1.8, 0.002);
  const std::string copy = text_of("copy");
  EXPECT_EQ(std::get<PowerLaw>(read_response(file("copy")).value()).gamma, 1.8);
  EXPECT_EQ(copy.find("2.21"), std::string::npos);
}

TEST_P(ResponseFile, HoldsACurve) {
  std::vector<double> values, intensities;
  for (int i = 0; i <= 16; ++i) {
    values.push_back(i / 16.0);
    intensities.push_back(10 + 100 * std::pow(i / 16.0, 1.9));
  }
  const ResponseCurve curve = response_curve(values, intensities);
  write_response(std::nullopt, file("alone"), curve, 1.9, 0.01);
  const auto read = std::get<ResponseCurve>(read_response(file("alone")).value());
  EXPECT_EQ(read.light, curve.light);
  EXPECT_EQ(read.slopes, curve.slopes);
  // A gamma that is written later takes the curve's place.
  write_response(file("alone"), file("alone"), PowerLaw{2}, 2, 0.01);
  EXPECT_TRUE(std::holds_alternative<PowerLaw>(read_response(file("alone")).value()));
}

TEST_P(ResponseFile, AnotherGammaTakesThePlaceOfACurve) {
  write_scanner(file("scanner"), example_scanner());
  const std::vector<double> values{0, 0.25, 0.5, 0.75, 1}, light{0, 0.1, 0.3, 0.6, 1};
  write_response(file("scanner"), file("scanner"), response_curve(values, light), 2.1, 0.01);
  const std::string text = text_of("scanner");
  const auto response = response_from(with_gamma(text, 1.8, "scanner"), "scanner");
  ASSERT_TRUE(response);
  EXPECT_EQ(std::get<PowerLaw>(*response).gamma, 1.8);
  const std::string without = with_gamma(text, std::nullopt, "scanner");
  EXPECT_FALSE(response_from(without, "scanner"));
  EXPECT_EQ(scanner_from(without, "scanner").camera.size, example_scanner().camera.size);
}

TEST_P(ResponseFile, RefusesWhatIsNoResponse) {
  const auto refused = [&](const std::map<std::string, StoredMatrix>& entries,
                           const std::string& words) {
    write_scanner(file("scanner"), example_scanner());
    write_file(file("bad"), with_entries(text_of("scanner"), entries, "scanner"));
    expect_error([&] { (void)read_response(file("bad")); }, {words});
  };
  refused({{"gamma", {1, 1, {30}}}}, "gamma 30 is out of range");
  refused({{"gamma", {1, 2, {2, 3}}}}, "gamma is not a number");
  refused({{"response_values", {1, 3, {0, 0.5, 1}}}}, "go together");
  refused({{"response_values", {1, 3, {0, 0.5, 1}}}, {"response_light", {1, 3, {0, 0, 0}}}},
          "does not rise");
}

INSTANTIATE_TEST_SUITE_P(Endings, ResponseFile, testing::Values(".yaml", ".xml"),
                         [](const auto& info) { return std::string(info.param).substr(1); });

TEST(ResponseFileForms, AreNotMixed) {
  const TemporaryFolder folder;
  write_scanner(folder.path() / "a.yaml", example_scanner());
  EXPECT_THROW(write_response(folder.path() / "a.yaml", folder.path() / "b.xml", PowerLaw{2}, 2, 0),
               Error);
}

}  // namespace
}  // namespace slipstream
