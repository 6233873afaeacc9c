// Right scans of every strategy are left in peace.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/statistics.h"
#include "response/response_fit.h"
#include "simulate/camera_picture.h"
#include "simulate/seen_scene.h"
#include "slipstream/check.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/virtual_world.h"
#include "tests/check/random_scans.h"
#include "tests/every_strategy.h"

namespace slipstream::right_table_test {

/// Upright and oblique boxes of 1 to 3 camera pixels in front of a wall or of nothing.
Scene wires(const Scanner& scanner, double pixels, bool with_wall) {
  const WorkingVolume volume = working_volume(scanner);
  const double width = pixels * volume.centre.z() / scanner.camera.intrinsic(0, 0);
  Scene scene;
  if (with_wall) {
    scene = scene_named("board", scanner);
    scene.front().pose.pretranslate(Eigen::Vector3d(0, 0, 0.2 * volume.extent));
    scene.front().texture = uniform_texture(0.6);
  }
  for (int i = 0; i < 5; ++i) {
    Body wire{.shape = Box{{width, 0.9 * volume.extent, width}}};
    wire.pose = Eigen::Translation3d(volume.centre +
                                     Eigen::Vector3d(0.2 * (i - 2), 0, 0.04 * i) * volume.extent) *
                Eigen::AngleAxisd(0.12 * (i - 2), Eigen::Vector3d::UnitZ());
    scene.push_back(std::move(wire));
  }
  return scene;
}

std::vector<Strategy> every_and_default_strategy() {
  std::vector<Strategy> all = every_strategy();
  for (const std::string_view name : strategy_names()) {
    all.push_back(make_strategy(std::string(name), {}));
  }
  return all;
}

/// A right scan and the truth about it.
struct RightScan {
  std::string name, strategy;
  VirtualWorld world;
  Scan scan;
  std::vector<VirtualScan> truths;  ///< of each camera
};

class RightTable : public RandomScans {
 public:
  using RandomScans::RandomScans;

  /// Of the strategies in turn; every fifth with other settings of a few.
  RightScan next_right(std::size_t number) {
    static const std::vector<Strategy> strategies = every_and_default_strategy();
    RightScan right;
    if (number % 5 == 4) {
      RandomScan random = next();
      right = {.name = random.name,
               .strategy = random.scan.sequence.strategy.name() + ", other settings",
               .scan = std::move(random.scan)};
      right.truths.push_back(std::move(random.truth));
      right.world.photometry = random.photometry;
      return right;
    }
    const Strategy& strategy = strategies[(number - number / 5) % strategies.size()];
    right.strategy = label_of(strategy);
    Sequence sequence{.strategy = strategy};
    Size camera = one_of<Size>({{96, 72},
                                {96, 72},
                                {96, 72},
                                {128, 96},
                                {128, 96},
                                {160, 120},
                                {160, 120},
                                {240, 180},
                                {320, 240},
                                {640, 480}});
    // A period has three pixels or more.
    while (camera.width < 3 * highest_frequency(strategy.layout()) ||
           camera.height < 3 * carrier_periods(strategy.layout())) {
      camera = {camera.width + 32, camera.height + 24};
    }
    // Along y the projector has fewer pixels than the finest code has stripes.
    const auto& code = strategy.layout().code;
    do {
      right.world.scanner = random_scanner(static_cast<unsigned>(whole(0, 1 << 30)), 0.1, camera);
      const Eigen::Vector3d& base = right.world.scanner.translation;
      sequence.axis = std::abs(base.x()) > std::abs(base.y()) ? Axis::x : Axis::y;
      sequence.projector = right.world.scanner.projector.size;
    } while (code && code->stripes > length_along(sequence.axis, sequence.projector));
    const auto kind =
        one_of<std::string>({"ideal", "ideal", "ideal", "bench", "bench", "bench", "harsh"});
    // A cue cannot be corrected.
    const bool correctable =
        !strategy.layout().cue && order_source(strategy.layout()) != OrderSource::neighbours;
    right.world.photometry = photometry_named(kind + (correctable ? "" : ",no-response"));
    Photometry& photometry = right.world.photometry;
    photometry.rays = std::min(photometry.rays, 4);
    photometry.physics.bounces = 0;
    photometry.bits = one_of<int>({8, 8, 10, 12, 14});
    photometry.seed = static_cast<std::uint64_t>(whole(0, 1 << 30));
    if (kind == "ideal") {
      photometry.ambient = between(0, 25);
      photometry.noise_variance = std::pow(10, between(-2, 0.6));
    }
    const auto scene = one_of<std::string>(
        {"board", "sphere", "boxes", "statue", "statue", "contrast", "wires", "wires"});
    right.world.scene = scene == "wires"
                            ? wires(right.world.scanner, between(1, 3), between(0, 1) < 0.5)
                            : scene_named(scene, right.world.scanner);
    try_exposures(sequence, scene == "contrast" ? 0.8 : 0.3);
    const bool two_cameras = !strategy.is_spectral() && between(0, 1) < 0.15;
    right.name =
        fmt::format("{}, {}, {}, {} wide, {} bits, {} exposures, {} motion{}", right.strategy, kind,
                    scene, camera.width, *photometry.bits, sequence.exposures.size(),
                    sequence.motion, two_cameras ? ", two cameras" : "");
    const auto take = [&](const VirtualWorld& world) {
      right.truths.push_back(
          take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry));
      return scan_of(world, sequence, right.truths.back().frames);
    };
    right.scan = take(right.world);
    if (two_cameras) right.scan.further_cameras.push_back(take(seen_from_second(right.world)));
    return right;
  }

 private:
  /// Several exposures, or a window of motion, if the sequence allows them.
  void try_exposures(Sequence& sequence, double share) {
    const auto keep = [&](Sequence changed) {
      try {
        require_mergeable(changed);
        sequence = std::move(changed);
      } catch (const Error&) {
        return;
      }
    };
    Sequence changed = sequence;
    if (between(0, 1) < share) {
      changed.exposures = one_of<std::vector<double>>({{1, 4}, {1, 4, 16}, {0.25, 1, 4}});
      keep(changed);
    } else if (sequence.strategy.name() != "pcps" && between(0, 1) < 0.5) {
      // A window of pcps, whose cue depends on the phase, gives few orders.
      changed.motion = one_of<int>({2, 4});
      keep(changed);
    }
  }

  static Scan scan_of(const VirtualWorld& world, const Sequence& sequence, const FrameSet& frames) {
    Scan scan = merged({.frames = frames, .sequence = sequence, .scanner = as_calibrated(world)});
    scan.scanner->calibrated_depths.reset();
    const auto* const power = std::get_if<PowerLaw>(&world.photometry.response);
    if (power != nullptr && power->gamma != 1) {
      scan.scanner->photometry.response = MeasuredResponse{*power, power->gamma, 0.01};
    }
    return scan;
  }
};

/// Why a warning is right, from the truth of one camera and from its cloud; empty if it is not.
std::string true_cause(const Scan& scan, const VirtualScan& truth, const Photometry& photometry,
                       const std::vector<Finding>& found) {
  // Shares of the pixels that the projector lights, and of the points.
  constexpr double many = 0.2, most = 0.5, most_ambient = 5, most_wrong_orders = 0.02;
  const Layout& layout = scan.sequence.strategy.layout();
  const double periods = layout.unwrapping->whole_stripes ? 0 : highest_frequency(layout);
  Engine engine(setup_for(scan));
  Cloud cloud;
  Maps maps;
  engine.cloud_and_maps(scan.frames, cloud, maps);
  const Uncertainty sigma = engine.uncertainty(cloud, maps, scan.frames);
  std::vector<double> errors, deviations, ambient;
  const Image<std::uint8_t> clipped = saturation_mask(scan.frames);
  int lit = 0, saturated = 0, wrong_orders = 0;
  for (std::size_t i = 0; i < cloud.validity.pixel_count(); ++i) {
    if (std::isnan(truth.coordinate.begin()[i])) continue;
    ++lit;
    const double alpha = truth.reflectivity.begin()[i];
    ambient.push_back((1 + truth.seen->albedo.begin()[i]) * photometry.ambient / (127.5 * alpha));
    const Validity validity = cloud.validity.begin()[i];
    if (clipped.begin()[i] != 0) ++saturated;
    const double error = std::abs(static_cast<double>(cloud.z.begin()[i]) - truth.depth.begin()[i]);
    if (validity != Validity::valid || !std::isfinite(error)) continue;
    errors.push_back(error);
    const auto off = static_cast<double>(maps.coordinate.begin()[i] - truth.coordinate.begin()[i]);
    if (periods * std::abs(off) > 0.5) ++wrong_orders;
    deviations.push_back(error / static_cast<double>(sigma.z.begin()[i]));
  }
  if (photometry.physics.flicker > 0 &&
      without_cause(found, CauseKind::flicker).size() < found.size())
    return "flicker";
  if (saturated > many * lit) return "saturated";
  const bool is_known = scan.scanner->photometry.response.has_value();
  const auto is_unproven = [](const Finding& finding) {
    return finding.kind == FindingKind::unproven_response;
  };
  if (!is_known && std::ranges::all_of(found, is_unproven)) return "unknown response";
  if (static_cast<double>(errors.size()) < most * lit) return "few points";
  if (wrong_orders > most_wrong_orders * static_cast<double>(errors.size()))
    return "wrong fringe orders";
  if (!ambient.empty() && quantile(ambient, 0.5) > most_ambient) return "ambient light";
  if (!errors.empty() && (quantile(errors, 0.5) > 1 || quantile(deviations, 0.5) > 5))
    return "wrong";
  return "";
}

std::string true_cause(const RightScan& right, const std::vector<Finding>& found) {
  std::string cause = true_cause(right.scan, right.truths[0], right.world.photometry, found);
  if (!cause.empty() || right.scan.further_cameras.empty()) return cause;
  return true_cause(right.scan.further_cameras[0], right.truths[1], right.world.photometry, found);
}

// Blur mixes the coordinates on both sides of a thing of a few pixels: it shows no slope. The table
// has too few scans of wires alone to meet those that were refused.
TEST(RightTable, WiresAloneAreLeftInPeace) {
  const Strategy strategy = make_strategy("gray-phase", {});
  for (const unsigned seed : {2U, 8U, 11U, 17U}) {
    VirtualWorld world{.scanner = random_scanner(seed, 0.1, {640, 480})};
    const Eigen::Vector3d& base = world.scanner.translation;
    const Sequence sequence{.strategy = strategy,
                            .axis = std::abs(base.x()) > std::abs(base.y()) ? Axis::x : Axis::y,
                            .projector = world.scanner.projector.size};
    world.scene = wires(world.scanner, 1 + seed % 8 / 4.0, false);
    world.photometry = photometry_named("harsh,no-response");
    world.photometry.rays = 4;
    world.photometry.physics.bounces = 0;
    world.photometry.bits = 12;
    const VirtualScan taken =
        take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
    Scan scan{.frames = taken.frames, .sequence = sequence, .scanner = as_calibrated(world)};
    scan.scanner->calibrated_depths.reset();
    for (const Finding& finding : check_scan(scan).findings) {
      ADD_FAILURE() << "seed " << seed << ": " << text_of(finding);
    }
  }
}

/// One scan of the set [first, end); `end`: the share over the set, after its scans.
struct Member {
  int first = 0, end = 0, number = 0;

  [[nodiscard]] bool is_share() const { return number == end; }
};

void PrintTo(const Member& member, std::ostream* out) {
  *out << "number " << member.number;
}

/// The set [first, end), and its share.
std::vector<Member> set_of(int first, int end) {
  std::vector<Member> set;
  for (int number = first; number <= end; ++number) set.push_back({first, end, number});
  return set;
}

std::string named(const testing::TestParamInfo<Member>& member) {
  return member.param.is_share() ? "share" : std::to_string(member.param.number);
}

/// Each scan alone, and how many of a set are warned of.
class RightTableScans : public testing::TestWithParam<Member> {
 protected:
  /// A scan with findings, right if there is a cause. It must not be refused without one.
  static void judge(const RightScan& right, const std::vector<Finding>& found,
                    const std::string& cause) {
    Line& line = table[right.strategy];
    ++line.scans;
    if (found.empty()) return;
    ++line.warned;
    if (!cause.empty()) ++line.with_cause;

    for (const Finding& finding : found) {
      const bool is_refused = finding.severity == Severity::wrong;
      EXPECT_FALSE(is_refused && cause.empty())
          << right.name << " is refused: " << text_of(finding);
      fmt::print("{}{}: {}\n", cause.empty() ? "" : "(" + cause + ") ", right.name,
                 text_of(finding));
    }
  }

  /// At most one scan of so many is warned of without a cause.
  static void judge_share(int scans_per_warning) {
    Line all;
    fmt::print("{:72} scans warned (with a true cause)\n", "strategy");
    for (const auto& [strategy, line] : table) {
      fmt::print("{:72} {:5} {:6} {:17}\n", strategy, line.scans, line.warned, line.with_cause);
      all.scans += line.scans;
      all.warned += line.warned;
      all.with_cause += line.with_cause;
    }
    fmt::print("{:72} {:5} {:6} {:17}\n", "all", all.scans, all.warned, all.with_cause);
    ASSERT_GT(all.scans, 0) << "the share is of the cases before; run the whole suite";
    EXPECT_LE(scans_per_warning * (all.warned - all.with_cause),
              std::max(scans_per_warning, all.scans));
    table.clear();
  }

 private:
  struct Line {
    int scans = 0, warned = 0, with_cause = 0;
  };

  static inline std::map<std::string, Line> table;
};

/// Scan `number` of the table: each hundred scans come one after the other from one seed.
RightScan right_scan(int number) {
  constexpr int hundred = 100;
  static std::optional<RightTable> scans;
  static int next = -1;

  if (number != next || number % hundred == 0) {
    scans.emplace(static_cast<std::uint64_t>(2026 + number / hundred));
    for (next = number - number % hundred; next < number; ++next) {
      scans->next_right(static_cast<std::size_t>(next));
    }
  }
  next = number + 1;
  return scans->next_right(static_cast<std::size_t>(number));
}

TEST_P(RightTableScans, AreLeftInPeace) {
  if (GetParam().is_share()) return judge_share(600);
  RightScan right = right_scan(GetParam().number);
  const std::vector<Finding> found = check_and_repair(right.scan).findings;
  judge(right, found, found.empty() ? "" : true_cause(right, found));
}

INSTANTIATE_TEST_SUITE_P(Day1, RightTableScans, testing::ValuesIn(set_of(0, 100)), named);
INSTANTIATE_TEST_SUITE_P(Day2, RightTableScans, testing::ValuesIn(set_of(100, 200)), named);
INSTANTIATE_TEST_SUITE_P(Day3, RightTableScans, testing::ValuesIn(set_of(200, 300)), named);
INSTANTIATE_TEST_SUITE_P(Night1, RightTableScans, testing::ValuesIn(set_of(300, 800)), named);
INSTANTIATE_TEST_SUITE_P(Night2, RightTableScans, testing::ValuesIn(set_of(800, 1300)), named);
INSTANTIATE_TEST_SUITE_P(Night3, RightTableScans, testing::ValuesIn(set_of(1300, 1900)), named);
INSTANTIATE_TEST_SUITE_P(Night4, RightTableScans, testing::ValuesIn(set_of(1900, 2400)), named);
INSTANTIATE_TEST_SUITE_P(Night5, RightTableScans, testing::ValuesIn(set_of(2400, 3000)), named);

std::vector<Image<double>> images_of(const FrameSet& frames) {
  std::vector<Image<double>> images;
  frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      Image<double>& image = images.emplace_back(view.size());
      for_each_pixel_in_order(view.size(), [&](int column, int row) {
        image(column, row) = static_cast<double>(view(column, row));
      });
    }
  });
  return images;
}

/// One scene of the bench, seen by cameras that expose and process pictures as those for people do.
class ProcessingCameras : public RandomScans {
 public:
  explicit ProcessingCameras(std::uint64_t seed) : RandomScans(seed) {
    world_.scanner = random_scanner(static_cast<unsigned>(whole(0, 1 << 30)), 0.1, {320, 240});
    name_ = one_of<std::string>({"board", "sphere", "boxes", "statue", "contrast", "wires"});
    world_.scene =
        name_ == "wires" ? wires(world_.scanner, 2, true) : scene_named(name_, world_.scanner);
    world_.photometry = photometry_named("bench");
    world_.photometry.rays = 4;
    world_.photometry.seed = seed;

    const Eigen::Vector3d& base = world_.scanner.translation;
    axis_ = std::abs(base.x()) > std::abs(base.y()) ? Axis::x : Axis::y;
    seen_ = take_scan(world_.scanner, world_.scene, pattern_set(PhaseMeasuring{}, axis_),
                      world_.photometry);
  }

  /// Each effect by itself, and all of them.
  std::vector<std::pair<std::string, Physics>> effects() {
    const Physics srgb = photometry_named("bench,tone-curve").physics;
    const auto curve = one_of<Response>({srgb.tone, PowerLaw{1 / 1.8}, logistic_curve(4, 0.5)});

    Physics toned = world_.photometry.physics, sharp = toned, exposed = toned, jpeg = toned;
    toned.tone = curve;
    sharp.sharpening = between(0.2, 1);
    exposed.auto_exposure = between(0, 0.1);
    jpeg.jpeg_quality = whole(75, 95);

    Physics all = toned;
    all.sharpening = sharp.sharpening;
    all.auto_exposure = exposed.auto_exposure;
    all.jpeg_quality = jpeg.jpeg_quality;
    return {{"tone curve", toned},
            {"sharpening", sharp},
            {"automatic exposure", exposed},
            {"JPEG", jpeg},
            {"all", all}};
  }

  /// What reaches the sensor.
  [[nodiscard]] std::vector<Image<double>> light_of(const Strategy& strategy) const {
    Photometry light = world_.photometry;
    light.bits.reset();
    light.physics.full_well = light.physics.read_noise = light.physics.row_noise = 0;
    light.physics.dark_spread = light.physics.sensitivity_spread = 0;
    return images_of(take_again(seen_, pattern_set(strategy, axis_), light));
  }

  [[nodiscard]] RightScan scan_of(const Strategy& strategy, std::vector<Image<double>> light,
                                  const std::string& effect, const Physics& physics) const {
    RightScan right{.name = fmt::format("{}, {}, {}", label_of(strategy), name_, effect),
                    .strategy = fmt::format("{}, {}", label_of(strategy), effect),
                    .world = world_};
    right.world.photometry.physics = physics;
    right.scan = {.frames = camera_pictures(std::move(light), 0, right.world.photometry),
                  .sequence = {strategy, axis_, {}, world_.scanner.projector.size},
                  .scanner = as_calibrated(right.world)};
    right.scan.scanner->calibrated_depths.reset();
    right.truths.push_back(seen_);
    return right;
  }

 private:
  VirtualWorld world_;
  VirtualScan seen_;
  Axis axis_ = Axis::x;
  std::string name_;
};

/// Warnings that are right: a tone curve bends the phase as a gamma does, automatic exposure
/// flickers, and fringes may be fainter than the check asks for.
bool is_earned(const Finding& finding, const RightScan& right) {
  const Physics& physics = right.world.photometry.physics;
  const bool has_phase = !right.scan.sequence.strategy.layout().bands.empty();
  if (finding.severity == Severity::wrong) return false;
  if (finding.kind == FindingKind::low_modulation || finding.kind == FindingKind::mostly_dark)
    return true;
  if (blames(finding, CauseKind::gamma)) return has_phase && !is_linear(physics.tone);
  return blames(finding, CauseKind::flicker) && physics.auto_exposure > 0;
}

/// Cameras that process their pictures, 40 scans each.
class RightTableProcessedScans : public RightTableScans {};

TEST_P(RightTableProcessedScans, AreLeftInPeace) {
  if (GetParam().is_share()) return judge_share(1000);

  ProcessingCameras cameras(static_cast<std::uint64_t>(4052 + GetParam().number));
  for (const Strategy& strategy : std::vector<Strategy>{
           GrayCode{.bits = 9, .reference = "inverse"},
           GrayCode{.bits = 9, .reference = "white-black"}, GrayPhase{},
           GrayPhase{.periods = 16, .reference = "inverse"}, DualFrequency{.steps = 4, .high = 16},
           DualFrequency{.steps = 5, .low_steps = 5, .high = 16}, MultiFrequency{.steps = {4}},
           MicroPhaseShifting{.periods = {25, 23, 22, 19}}}) {
    const std::vector<Image<double>> light = cameras.light_of(strategy);

    for (const auto& [effect, physics] : cameras.effects()) {
      RightScan right = cameras.scan_of(strategy, light, effect, physics);
      const std::vector<Finding> found = check_and_repair(right.scan).findings;
      const bool earned = std::ranges::all_of(
          found, [&](const Finding& finding) { return is_earned(finding, right); });
      judge(right, found, earned ? effect : true_cause(right, found));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Day, RightTableProcessedScans, testing::ValuesIn(set_of(0, 1)), named);
INSTANTIATE_TEST_SUITE_P(Night1, RightTableProcessedScans, testing::ValuesIn(set_of(1, 16)), named);
INSTANTIATE_TEST_SUITE_P(Night2, RightTableProcessedScans, testing::ValuesIn(set_of(16, 31)),
                         named);
INSTANTIATE_TEST_SUITE_P(Night3, RightTableProcessedScans, testing::ValuesIn(set_of(31, 46)),
                         named);
INSTANTIATE_TEST_SUITE_P(Night4, RightTableProcessedScans, testing::ValuesIn(set_of(46, 61)),
                         named);
INSTANTIATE_TEST_SUITE_P(Night5, RightTableProcessedScans, testing::ValuesIn(set_of(61, 75)),
                         named);

}  // namespace slipstream::right_table_test
