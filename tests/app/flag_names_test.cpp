// Texts of the library in the program's words.
#include "app/flag_names.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/output.h"
#include "slipstream/engine.h"
#include "slipstream/scanner.h"

namespace slipstream::app::flag_names_test {

TEST(FlagNames, SettingsBecomeFlags) {
  EXPECT_EQ(with_flags("`order` is only for grey scans"), "--order is only for grey scans");
  EXPECT_EQ(with_flags("check `steps` and `low_steps`"), "check --steps and --low-steps");
  EXPECT_EQ(with_flags("omit `no_loop`"), "omit --no-loop");
  EXPECT_EQ(flag_of("low_steps"), "--low-steps");
}

TEST(FlagNames, ValuesFollowTheirFlag) {
  EXPECT_EQ(with_flags("try `order 2,0,1`"), "try --order 2,0,1");
  EXPECT_EQ(with_flags("`publish web:8080`: expected"), "--publish web:8080: expected");
  EXPECT_EQ(with_flags("`camera_bits 17` is out of range"), "--camera-bits 17 is out of range");
  EXPECT_EQ(with_flags("`excluded pose 3 -- old`"), "`excluded pose 3 -- old`");
}

TEST(FlagNames, OperationsBecomeCommands) {
  EXPECT_EQ(with_flags("measure it with `calibrate_gamma()`"),
            "measure it with slipstream calibrate gamma");
  EXPECT_EQ(with_flags("find it with `reconstruct()` `gamma blind`"),
            "find it with slipstream reconstruct --gamma blind");
}

TEST(FlagNames, FlagsAreCalledLikeTheirSettings) {
  EXPECT_EQ(with_flags("lower `minimum_modulation`"), "lower --minimum-modulation");
  EXPECT_EQ(with_flags("`widest_gap 3`"), "--widest-gap 3");
  EXPECT_EQ(with_flags("set `ambient_light`"), "set --ambient-light");

  const auto is_called_alike = [](const Setting& setting, const auto&) {
    const bool is_offered = *setting.option != '\0' && !setting.option_clears;
    if (!is_offered) return;
    EXPECT_EQ(flag_of(setting.name), flag_of(setting.option));
  };
  const ReconstructSettings settings;
  ReconstructSettings::for_each_setting(settings, is_called_alike);
  CleanSettings::for_each_setting(settings.clean, is_called_alike);
  const PhotometricCalibration photometry;
  PhotometricCalibration::for_each_setting(photometry, is_called_alike);
}

TEST(FlagNames, FormerNamesAreRead) {
  EXPECT_EQ(with_former_name("--widest-gap"), "--widest-gap,--fill");
  EXPECT_EQ(with_former_name("--steps"), "--steps");
  EXPECT_EQ(present_name("fill"), "widest-gap");
  EXPECT_EQ(present_name("steps"), "steps");
  EXPECT_TRUE(is_former_name("min-modulation"));
  EXPECT_FALSE(is_former_name("minimum-modulation"));
}

TEST(FlagNames, TwoFlagsDiffer) {
  EXPECT_EQ(with_flags("`least_alpha 2`"), "--least-reflectivity 2");
  EXPECT_EQ(with_flags("`noise_variance`"), "--noise-variance");
}

TEST(FlagNames, OtherTextStays) {
  for (const char* const text :
       {"", "no name", "`", "``", "a `quoted", "`Order`", "`2,0`", "`order `", "`a/b.ply`",
        "`view( )`", "see `project --list`", "use `slipstream record`", "a--b"}) {
    EXPECT_EQ(with_flags(text), text);
  }

  // A lone backquote does not hide the name after it.
  EXPECT_EQ(with_flags("it`s: `order` and `view()"), "it`s: --order and `view()");
  EXPECT_EQ(with_flags(with_flags("`order 1`")), "--order 1");
}

TEST(FlagNames, OutputHasThem) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  Output output(false);
  output.say("try `order {}`", 1);
  output.warn("`steps` differ");
  output.tell_failure("`axis z`");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "try --order 1\n");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "warning: --steps differ\nslipstream: --axis z\n");
}

TEST(FlagNames, TheDocumentHasThemExceptInPaths) {
  const nlohmann::json document = {{"error", "try `order 1`"},
                                   {"scans", {{{"warnings", {"`steps` differ"}}, {"points", 3}}}},
                                   {"files", {{"cloud", "`order`"}}}};
  const nlohmann::json expected = {{"error", "try --order 1"},
                                   {"scans", {{{"warnings", {"--steps differ"}}, {"points", 3}}}},
                                   {"files", {{"cloud", "`order`"}}}};
  EXPECT_EQ(document_with_flags(document), expected);
}

}  // namespace slipstream::app::flag_names_test
