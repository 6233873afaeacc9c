// Daily: the one way of a scan to its results, for every caller. Not a case of the engine's tests,
// which see neither the check, nor further cameras, nor the other axis.
#include "slipstream/scan_job.h"

#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "reconstruct/epipolar.h"
#include "reconstruct/phase_matcher.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::scan_job_test {

template <class Pixel>
bool same_bytes(const Image<Pixel>& a, const Image<Pixel>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.begin(), b.begin(), a.pixel_count() * sizeof(Pixel)) == 0);
}

bool same_cloud(const Cloud& a, const Cloud& b) {
  return same_bytes(a.x, b.x) && same_bytes(a.y, b.y) && same_bytes(a.z, b.z) &&
         same_bytes(a.validity, b.validity);
}

const Sequence dual{.strategy = make_strategy("dual-frequency", {{"high", 16}, {"low", 1}})};

Scan scan_of(const Sequence& sequence, const Scanner& scanner = example_scanner({160, 120})) {
  VirtualScan taken =
      scan_of_scene("statue", scanner, pattern_set(sequence), {.noise_variance = 1.6});
  return merged({.frames = std::move(taken.frames), .sequence = sequence, .scanner = scanner});
}

Scan scan_of_two_cameras() {
  const Scanner first = example_scanner({160, 120}), second = second_scanner(first);
  Scan scan = scan_of(dual, first);

  const Scene seen = seen_from_second(scene_named("statue", first), first, second);
  scan.further_cameras.push_back(
      {.frames = take_scan(second, seen, pattern_set(dual), {.noise_variance = 1.6}).frames,
       .sequence = dual,
       .scanner = second});
  return scan;
}

TEST(ScanJob, IsTheCloudOfAnEngineMadeForTheScan) {
  const Scan scan = scan_of(dual);
  Cloud expected;
  Engine(setup_for(scan)).cloud(scan.frames, expected);

  const ScanResult result = reconstruct(scan);
  EXPECT_TRUE(same_cloud(result.cloud, expected));
  EXPECT_EQ(result.counts, count_by_validity(expected.validity));
  EXPECT_TRUE(result.checked.findings.empty());
  EXPECT_EQ(result.backend, "fused");
}

TEST(ScanJob, MatchesTwoCameras) {
  const Scan scan = scan_of_two_cameras();
  const Scan& second = scan.further_cameras.front();
  PhaseMatcher match(*scan.scanner, *second.scanner, dual);

  const ScanResult result = reconstruct(scan);
  EXPECT_TRUE(same_cloud(result.cloud, match(scan, second).cloud));
  EXPECT_GT(result.counts[0], 2000U);
  EXPECT_EQ(result.gamma.source, "two cameras");
}

TEST(ScanJob, ComparesBothAxes) {
  Sequence both = dual;
  both.both_axes = true;
  const Scan scan = scan_of(both);
  Cloud expected;
  Maps maps;
  const EngineSetup setup = setup_for(scan);
  Engine(setup).cloud_and_maps(scan.frames, expected, maps);
  const EpipolarCheck check = check_epipolar(setup, scan.other_axis.front(), maps, expected);

  const ScanResult result = reconstruct(scan);
  EXPECT_TRUE(same_cloud(result.cloud, expected));
  ASSERT_TRUE(result.epipolar);
  EXPECT_EQ(result.epipolar->doubted, check.doubted);
  EXPECT_EQ(result.epipolar->median, check.median);
}

/// A scan with patterns along both axes, whose scanner file has the projector's image displaced.
Scan scan_with_projector_off(double pixels) {
  Sequence both = dual;
  both.both_axes = true;
  Scan scan = scan_of(both);
  scan.scanner->projector.intrinsic(1, 2) += pixels;
  return scan;
}

TEST(ScanJob, WarnsOfACalibrationThatIsAPixelOff) {
  const ScanResult right = reconstruct(scan_with_projector_off(0));
  const ScanResult result = reconstruct(scan_with_projector_off(1));
  EXPECT_GE(result.counts[0] + 20, right.counts[0]);
  ASSERT_EQ(result.checked.findings.size(), 1U);
  EXPECT_EQ(result.checked.findings.front().kind, FindingKind::axes_disagree);
  EXPECT_EQ(result.checked.findings.front().severity, Severity::doubtful);

  Scan known = scan_with_projector_off(1);
  known.scanner->calibration_rms = 0.8;
  EXPECT_TRUE(reconstruct(known).checked.findings.empty());
}

/// The diagnostics that refuse a scan; {} if it is accepted.
std::vector<Finding> refusal_of(const Scan& scan, const ScanJobSettings& settings = {}) {
  try {
    (void)reconstruct(scan, settings);
  } catch (const RefusedScan& refused) {
    return refused.findings();
  }
  return {};
}

TEST(ScanJob, RefusesAxesThatContradictEachOther) {
  const Scan scan = scan_with_projector_off(20);
  const std::vector<Finding> findings = refusal_of(scan);
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().kind, FindingKind::axes_disagree);
  EXPECT_EQ(findings.front().causes.front().kind, CauseKind::rig_moved);
  EXPECT_GT(reconstruct(scan, {.keep_refused = true}).counts[0], 1000U);
}

TEST(ScanJob, RefusesACloudWithoutPoints) {
  ScanJobSettings settings;
  settings.reconstruct.nearest = 10;
  settings.reconstruct.farthest = 20;
  const std::vector<Finding> findings = refusal_of(scan_of(dual), settings);
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.front().kind, FindingKind::few_points);
  EXPECT_EQ(remedies_of(findings.front()), "check the depth range, `nearest` and `farthest`");
}

TEST(ScanJob, SaysWhatToDoAboutDarkPixels) {
  ScanJobSettings settings;
  settings.reconstruct.minimum_modulation = 120;
  settings.keep_refused = true;
  const ScanResult result = reconstruct(scan_of(dual), settings);

  const Finding& few = result.checked.findings.back();
  ASSERT_EQ(few.kind, FindingKind::few_points);
  EXPECT_NE(remedies_of(few).find("lower `minimum_modulation`"), std::string::npos);
}

TEST(ScanJob, RefusesAScanThatContradictsItsPatterns) {
  Scan scan = scan_of(dual);
  scan.frames = reordered(std::move(scan.frames), {0, 2, 1, 3, 5, 4});
  ScanJobSettings settings;

  try {
    (void)reconstruct(scan);
    ADD_FAILURE() << "accepted";
  } catch (const RefusedScan& refused) {
    ASSERT_FALSE(refused.findings().empty());
    EXPECT_EQ(refused.findings().front().severity, Severity::wrong);
    EXPECT_TRUE(blames(refused.findings().front(), CauseKind::frame_order)) << refused.what();
  }

  settings.keep_refused = true;
  const ScanResult kept = reconstruct(scan, settings);
  EXPECT_TRUE(any_wrong(kept.checked.findings));
  EXPECT_FALSE(kept.cloud.z.empty());
}

TEST(ScanJob, TakesLightAndNoiseOfItsSettingsBeforeTheScanners) {
  Scan scan = scan_of(dual);
  scan.scanner->photometry = {.ambient = 3, .noise_variance = 1, .noise_gain = 0.01};
  const CheckedJob job = checked_job(scan, {.photometry = {.noise_variance = 2}});
  const PhotometricCalibration& known = job.setup.scanner.photometry;
  EXPECT_EQ(known.ambient, 3);
  EXPECT_EQ(known.noise_variance, 2);
  EXPECT_EQ(known.noise_gain, 0.01);
}

TEST(ScanJob, ChecksAScanAsItsReconstructionDoes) {
  Scan scan = scan_of(dual);
  scan.frames = reordered(std::move(scan.frames), {1, 2, 3, 4, 5, 0});
  const ScanResult result = reconstruct(scan);
  const ScanCheck checked = check(scan);
  EXPECT_EQ(checked.checked.repairs, result.checked.repairs);
  EXPECT_EQ(checked.checked.median_depth, result.checked.median_depth);
  EXPECT_FALSE(scan.order.empty());

  // Also without a scanner.
  scan.scanner.reset();
  const ScanCheck without = check(scan);
  EXPECT_TRUE(without.checked.findings.empty());
  EXPECT_EQ(without.checked.median_depth, 0);
}

TEST(ScanJob, PutsSlippedFramesInOrder) {
  Scan scan = scan_of(dual);
  const ScanResult expected = reconstruct(scan);
  scan.frames = reordered(std::move(scan.frames), {1, 2, 3, 4, 5, 0});

  const ScanResult result = reconstruct(scan);
  EXPECT_EQ(result.checked.repairs.size(), 1U);
  EXPECT_TRUE(same_cloud(result.cloud, expected.cloud));
}

TEST(ScanJob, NeedsAScannerForPointsOnly) {
  Scan scan = scan_of(dual);
  scan.scanner.reset();
  scan.sequence.projector = {1280, 800};
  EXPECT_THROW((void)reconstruct(scan), Error);

  const ScanResult maps = reconstruct(scan, {.output = ScanOutput::maps});
  EXPECT_EQ(maps.maps.coordinate.size(), (Size{160, 120}));
  EXPECT_GT(maps.counts[0], 2000U);
  EXPECT_TRUE(maps.cloud.z.empty());
}

TEST(ScanJob, GivesTheSameFromScanToScan) {
  const Scan scan = scan_of(dual), other = scan_of({.strategy = make_strategy("pmp", {})});
  ScanJob job;
  ScanResult first = job(scan);
  const Cloud expected = first.cloud;
  job.reuse(std::move(first.cloud));

  EXPECT_TRUE(same_cloud(job(other).cloud, reconstruct(other).cloud));
  EXPECT_TRUE(same_cloud(job(scan).cloud, expected));
}

TEST(ScanJob, GivesUncertaintyAndMapsOnRequest) {
  Scan scan = scan_of(dual);
  const ScanResult plain = reconstruct(scan);
  EXPECT_TRUE(plain.maps.coordinate.empty());
  EXPECT_FALSE(plain.uncertainty);

  const ScanResult more = reconstruct(scan, {.maps = true, .uncertainty = true});
  EXPECT_TRUE(same_cloud(more.cloud, plain.cloud));
  EXPECT_EQ(more.maps.wrapped_phase.size(), more.cloud.size());
  ASSERT_TRUE(more.uncertainty);
  EXPECT_EQ(more.uncertainty->z.size(), more.cloud.size());
}

TEST(ScanJob, ConfirmsCoordinatesWithoutOtherMaps) {
  const ScanResult result = reconstruct(scan_of(dual), {.sure_coordinates = true});
  EXPECT_EQ(result.maps.coordinate.size(), result.cloud.size());
}

TEST(ScanJob, RefusesACameraPairWithoutItsSecondCamera) {
  Scan scan = scan_of(dual);
  scan.camera_pair = std::exchange(scan.scanner, std::nullopt);
  EXPECT_THROW((void)reconstruct(scan), Error);
}

}  // namespace slipstream::scan_job_test
