// One table of what the check tells of broken scans: every kind of mistake, every strategy, real
// sets and virtual scans in three worlds. Every hint is followed.
#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "base/statistics.h"
#include "slipstream/check.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/gray_code.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_world.h"
#include "tests/check/followed_hints.h"
#include "tests/check/mistake_lists.h"
#include "tests/check/real_sets.h"
#include "tests/every_strategy.h"

namespace slipstream::broken_table_test {

namespace fs = std::filesystem;

/// A right scan, and its mistakes.
struct RightScan {
  std::string strategy;
  Scan scan;
  Image<double> depth{};  ///< true depth, mm; empty: that of the right scan itself
  Mistakes mistakes{};
  CheckSettings settings{};
  std::function<FrameSet()> take{};  ///< gives the frames, if they are not there yet
};

/// The settings of the captures: shared/data/README.md.
RightScan real_scan(const std::string& set) {
  const bool with_depths = set != "skull-alone";
  const fs::path folder = shared_data() / (with_depths ? set : "skull");
  RightScan right;
  if (set.starts_with("skull")) {
    right.scan = skull();
    if (with_depths) right.scan.scanner->calibrated_depths = skull_depths;
    const auto bent = [](double gamma) {
      return pixels(all_frames(6),
                    [=](double level, int, int) { return 255 * std::pow(level / 255, gamma); });
    };
    right.mistakes = {{"gamma of the frames 2.2", bent(2.2), {"gamma"}, "gamma"},
                      {"gamma of the frames 0.5", bent(0.5), {"gamma"}, "gamma"},
                      {"bands with unlike light",
                       pixels({3, 4, 5}, [](double level, int, int) { return 0.9 * level; }),
                       {"flickers"},
                       "light"}};
  } else if (set == "slmaster-mono") {
    right.scan = real_scan(
        folder, names_of(18, [](int n) { return fmt::format("frame_{:02}.png", n); }),
        GrayPhase{.steps = 12, .shifts = {std::numbers::pi, true}}, {1920, 1080}, "caliInfo.yml");
    right.scan.scanner->calibrated_depths = {600, 860};
  } else if (set == "cpsd-plane") {
    right.scan = real_scan(
        folder,
        names_of(48, [](int n) { return fmt::format("f{}_s{:02}.png", n / 12 + 1, n % 12 + 1); }),
        MultiFrequency{.steps = {12},
                       .periods = {1, 4, 16, 64},
                       .unwrapping = "hierarchical",
                       .shifts = {std::numbers::pi, true}},
        {1920, 1080});
    right.settings.photometry.response = MeasuredResponse{PowerLaw{2}, 2, 0.05};
  } else {
    std::vector<std::string> names =
        names_of(20, [](int n) { return fmt::format("pat{:02}.png", 12 + n); });
    right.scan = real_scan(
        folder, names, GrayCode{.bits = 10, .reference = "inverse", .stripes = 960}, {1920, 1080});
  }
  right.strategy = right.scan.sequence.strategy.name();
  for (Mistake& mistake : mistakes_of(right.scan)) right.mistakes.push_back(std::move(mistake));
  return right;
}

std::vector<Strategy> all_strategies() {
  std::vector<Strategy> all{MicroPhaseShifting{},
                            PhaseMeasuring{.steps = 3},
                            DualFrequency{.steps = 4, .high = 32},
                            DualFrequency{.steps = 3, .high = 16},
                            DualFrequency{.steps = 3, .high = 8},
                            GrayPhase{.steps = 12, .shifts = {std::numbers::pi, true}}};
  for (const auto& more :
       {every_phase_strategy(), every_strategy_on_cpu(), every_strategy_with_cue(), every_code()}) {
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

VirtualWorld world_of(const std::string& scene, const std::string& world) {
  return virtual_world({.scene = scene, .camera = {320, 240}, .world = world, .seed = 3});
}

/// A scanner above the projector: its stripes along x hardly move with depth.
VirtualWorld above(VirtualWorld world, const std::string& scene) {
  world.scanner.rotation = Eigen::AngleAxisd(0.22, Eigen::Vector3d::UnitX()).toRotationMatrix();
  world.scanner.translation = Eigen::Vector3d(0, 176, 40);
  world.scene = scene_named(scene, world.scanner);
  return world;
}

/// Scans of every strategy under one light. Traces the scene once.
class WorldScans {
 public:
  WorldScans(const std::string& scene, const std::string& name)
      : is_ideal_(name == "ideal"),
        world_(world_of(scene, name)),
        seen_(take_scan(world_.scanner, world_.scene, pattern_set(PhaseMeasuring{}, Axis::x),
                        world_.photometry)),
        above_(above(world_, scene)) {
    if (is_ideal_) {
      from_above_ = take_scan(above_.scanner, above_.scene, pattern_set(PhaseMeasuring{}, Axis::x),
                              above_.photometry);
    }
  }

  [[nodiscard]] RightScan of(const Strategy& strategy) const {
    Sequence sequence{strategy, Axis::x, {}, world_.scanner.projector.size};
    Scan scan{.sequence = sequence, .scanner = as_calibrated(world_)};
    if (const Response& response = world_.photometry.response; response != Response{}) {
      scan.scanner->photometry.response = MeasuredResponse{response, 2.2, 0.01};
    }
    Mistakes mistakes = mistakes_of(scan);
    if (!is_code_alone(strategy)) {
      mistakes.push_back({"projector's gamma of 2.2",
                          [=, this](Scan& s) {
                            Photometry bent = world_.photometry;
                            bent.response = PowerLaw{2.2};
                            s.frames = take_again(seen_, pattern_set(s.sequence), bent);
                            s.scanner->photometry.response.reset();
                          },
                          {"gamma"},
                          "gamma"});
    }
    if (is_ideal_ && !is_code_alone(strategy)) {
      mistakes.push_back({"one-bit patterns in focus",
                          [=, this](Scan& s) {
                            s.sequence.binary = true;
                            s.frames =
                                take_again(seen_, pattern_set(s.sequence), world_.photometry);
                          },
                          {"one-bit"},
                          "one bit"});
      mistakes.push_back({"camera above the projector",
                          [=, this](Scan& s) {
                            s.frames =
                                take_again(from_above_, pattern_set(s.sequence), above_.photometry);
                            s.scanner = as_calibrated(above_);
                          },
                          {"patterns along y"},
                          "along the baseline"});
    }
    return {
        .strategy = strategy.name(),
        .scan = std::move(scan),
        .depth = seen_.depth,
        .mistakes = std::move(mistakes),
        .take = [=, this] { return take_again(seen_, pattern_set(sequence), world_.photometry); }};
  }

 private:
  static bool is_code_alone(const Strategy& strategy) {
    return strategy.layout().unwrapping->whole_stripes;
  }

  bool is_ideal_;
  VirtualWorld world_;
  VirtualScan seen_;
  VirtualWorld above_;
  VirtualScan from_above_{};
};

/// How wrong the cloud is where there is a point, or the coordinates without a scanner.
struct CloudError {
  double median = 0;  ///< mm or projector pixels; infinite if all points are lost
  double sigma = 0;   ///< median of the claimed ones
  double share = 0;   ///< of the reference's pixels

  [[nodiscard]] bool is_wrong(const CloudError& right) const {
    return median > std::max({1.0, 1.5 * right.median}) ||
           (sigma > 0 && median > std::max(5 * sigma, 1.5 * right.median));
  }
};

struct Measured {
  Image<double> values{};  ///< depth or coordinate, NaN if invalid
  std::vector<double> sigmas{};
};

Measured measured(const Scan& scan) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (!scan.scanner || !has_geometry(*scan.scanner)) {
    Scanner without;
    without.camera.size = scan.frames.size();
    without.projector.size = scan.sequence.projector;
    Engine engine(without, scan.sequence);
    Measured result{measured_coordinates(engine, scan.frames)};
    for (double& value : result.values) value *= scan.sequence.projector.width;
    return result;
  }
  Engine engine(setup_for(scan));
  Cloud cloud;
  Maps maps;
  engine.cloud_and_maps(scan.frames, cloud, maps);
  const Uncertainty uncertainty = engine.uncertainty(cloud, maps, scan.frames);
  Measured result{Image<double>(cloud.size())};
  for (std::size_t i = 0; i < result.values.pixel_count(); ++i) {
    const bool valid = cloud.validity.begin()[i] == Validity::valid;
    result.values.begin()[i] = valid ? static_cast<double>(cloud.z.begin()[i]) : nan;
    if (valid) result.sigmas.push_back(uncertainty.z.begin()[i]);
  }
  return result;
}

CloudError error_of(const Scan& scan, const Image<double>& truth) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  try {
    Measured found = measured(scan);
    if (found.values.size() != truth.size()) return {infinite, 0, 0};
    std::vector<double> errors;
    int wanted = 0;
    for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
      if (!std::isfinite(truth.begin()[i])) continue;
      ++wanted;
      const double off = std::abs(found.values.begin()[i] - truth.begin()[i]);
      if (std::isfinite(off)) errors.push_back(off);
    }
    if (errors.empty()) return {0, 0, 0};
    return {quantile(errors, 0.5), found.sigmas.empty() ? 0 : quantile(found.sigmas, 0.5),
            static_cast<double>(errors.size()) / wanted};
  } catch (const Error&) {
    return {0, 0, 0};  // refused by the engine
  }
}

/// What the check says in one line.
std::string text_of(const std::vector<Finding>& findings) {
  std::vector<std::string> texts;
  for (const Finding& finding : findings) texts.push_back(slipstream::text_of(finding));
  return findings.empty() ? "silent" : fmt::format("{}", fmt::join(texts, " | "));
}

/// Mistakes that frames and scanner cannot contradict: "Undetected errors" in
/// docs/reference/scan-validation.md.
bool is_listed(const Scan& scan, const Mistake& mistake) {
  const Layout& layout = scan.sequence.strategy.layout();
  const bool has_scanner = scan.scanner && has_geometry(*scan.scanner);
  if (mistake.name == "inverted" || mistake.name.starts_with("another rig")) return true;
  if (is_single_band(layout) && layout.frames == 3 && mistake.kind == "light") return true;
  if (layout.unwrapping->whole_stripes && mistake.name == "other axis") return true;
  const auto& name = scan.sequence.strategy.name();
  if (name == "pcps" && (mistake.kind == "origin" || mistake.kind == "slip")) return true;
  if (name == "gray-phase" && mistake.kind == "periods") return true;  // of as many bits
  if (!has_scanner && layout.code && mistake.name == "frames 0 and 1 swapped") return true;
  if (has_scanner && scan.scanner->calibrated_depths) return false;
  return mistake.name == "halved" || mistake.name == "cropped" ||
         (!layout.code && (mistake.kind == "slip" || mistake.kind == "origin"));
}

struct Count {
  int made = 0, told = 0, caused = 0, harmless = 0, listed = 0, wrong = 0;
};

/// Over all scans that this program has broken.
struct Table {
  std::map<std::string, Count> kinds, strategies;
  Count all;
  int hints = 0;
  std::vector<std::string> right, silent, other_cause, bad_hints;
  std::vector<std::pair<double, std::string>> times;
};

Table& table() {
  static Table all;
  return all;
}

std::string row(const std::string& name, const Count& count) {
  return fmt::format("{:24} {:5} {:5} {:5} {:5} {:5} {:5}\n", name, count.made, count.told,
                     count.caused, count.harmless, count.listed, count.wrong);
}

void print(Table& all) {
  fmt::print("{:24}  made  told cause harml listd wrong\n", "");
  for (const auto& [name, count] : all.kinds) fmt::print("{}", row(name, count));
  fmt::print("\n");
  for (const auto& [name, count] : all.strategies) fmt::print("{}", row(name, count));
  fmt::print("\nRight scans told of something:\n{}\n", fmt::join(all.right, "\n"));
  fmt::print("\n{}\nSilent:\n{}\n\nOther cause:\n{}\n\n{} hints followed; bad ones:\n{}\n",
             row("all", all.all), fmt::join(all.silent, "\n"), fmt::join(all.other_cause, "\n"),
             all.hints, fmt::join(all.bad_hints, "\n"));
  std::ranges::sort(all.times, std::greater());
  double sum = 0;
  for (const auto& [seconds, name] : all.times) sum += seconds;
  fmt::print("\nSlowest checks ({:.1f} s in all):\n", sum);
  for (std::size_t i = 0; i < std::min<std::size_t>(8, all.times.size()); ++i) {
    fmt::print("{:.2f} s {}\n", all.times[i].first, all.times[i].second);
  }
}

bool names_cause(const std::vector<Finding>& findings, const Words& causes) {
  return std::ranges::any_of(findings, [&](const Finding& finding) {
    return std::ranges::any_of(causes, [&](const std::string& cause) {
      return causes_of(finding).find(cause) != std::string::npos;
    });
  });
}

/// One set of right scans: breaks them, and asks the check.
class BrokenSet {
 public:
  BrokenSet(std::string name, const RightScan& right) : name_(std::move(name)), right_(right) {
    usual_ = check_scan(right.scan, right.settings).findings;
    if (!usual_.empty()) {
      table().right.push_back(title("right") + ": " + text_of(usual_));
      return;
    }
    truth_ = right.depth.pixel_count() > 0 ? right.depth : measured(right.scan).values;
    right_error_ = error_of(right.scan, truth_);
  }

  void tell(const Mistake& mistake) {
    if (!usual_.empty()) return;  // in harsh light some strategies do not measure
    Scan broken = right_.scan;
    mistake.make(broken);
    const auto start = std::chrono::steady_clock::now();
    const std::vector<Finding> found = check_scan(broken, right_.settings).findings;
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    table().times.emplace_back(seconds.count(), title(mistake.name));
    const bool told = !found.empty();
    const bool caused = names_cause(found, mistake.causes);
    const CloudError error = told ? CloudError{} : error_of(broken, truth_);
    const bool silent = !told && !caused, harms = silent && error.is_wrong(right_error_);
    const bool listed = harms && is_listed(right_.scan, mistake), wrong = harms && !listed;
    for (Count* count :
         {&table().all, &table().kinds[mistake.kind], &table().strategies[right_.strategy]}) {
      ++count->made;
      count->told += static_cast<int>(!silent);
      count->caused += static_cast<int>(caused);
      count->harmless += static_cast<int>(silent && !harms);
      count->listed += static_cast<int>(listed);
      count->wrong += static_cast<int>(wrong);
    }
    if (silent) {
      table().silent.push_back(fmt::format(
          "{}: {}median {:.3g} mm (right: {:.3g}), sigma {:.3g}, {:.0f} % of the points",
          title(mistake.name),
          wrong    ? "WRONG, "
          : listed ? "listed, "
                   : "",
          error.median, right_error_.median, error.sigma, 100 * error.share));
    } else if (!caused) {
      table().other_cause.push_back(title(mistake.name) + ": " + text_of(found));
    }
    for (const Finding& finding : found) follow_all(finding, broken, mistake.name);
  }

 private:
  [[nodiscard]] std::string title(const std::string& mistake) const {
    return fmt::format("{}, {} ({}), {}", name_, right_.strategy, fmt::join(numbers(), " "),
                       mistake);
  }

  [[nodiscard]] std::vector<std::string> numbers() const {
    std::vector<std::string> texts;
    for (const auto& [key, value] : right_.scan.sequence.strategy.settings()) {
      texts.push_back(key + " " + value.text());
    }
    return texts;
  }

  /// With a hint the scan must not be refused; a single one must give the right cloud.
  void follow_all(const Finding& finding, const Scan& broken, const std::string& mistake) {
    const bool single =
        finding.remedies.size() == 1 && finding.causes.size() == 1 && finding.remark.empty();

    for (const Remedy& remedy : finding.remedies) {
      Scan mended = broken;
      if (!follow(remedy, mended)) continue;
      ++table().hints;
      const std::vector<Finding> left = check_scan(mended, right_.settings).findings;
      if (any_wrong(left)) {
        table().bad_hints.push_back(
            fmt::format("{}: {} leaves {}", title(mistake), remedy.text, text_of(left)));
      } else if (const CloudError error = error_of(mended, truth_);
                 single && error.is_wrong(right_error_)) {
        table().bad_hints.push_back(fmt::format("{}: {} alone leaves {:.3g} mm, {}", title(mistake),
                                                remedy.text, error.median,
                                                slipstream::text_of(finding)));
      }
    }
  }

  std::string name_;
  const RightScan& right_;
  std::vector<Finding> usual_;
  Image<double> truth_;
  CloudError right_error_;
};

struct Part {
  std::string set;  ///< a real set, or scene and world: "statue_ideal"
  int every = 1;    ///< one mistake of so many
};

class BrokenScans : public testing::TestWithParam<Part> {
 protected:
  static void TearDownTestSuite() {
    Table& all = table();
    print(all);
    const int tellable = all.all.made - all.all.harmless - all.all.listed;
    EXPECT_GE(100 * all.all.caused, 97 * tellable);
    EXPECT_LE(all.all.wrong, std::max(1, 3 * all.all.made / 1000));  // a tenth may have one
    EXPECT_LE(1000 * all.bad_hints.size(), 3 * static_cast<std::size_t>(all.hints));
    all = {};
  }
};

/// Chooses among the mistakes by a hash of names, so that the same ones are chosen everywhere.
std::uint64_t draw(const std::string& text) {
  std::uint64_t hash = 1469598103934665603U;  // FNV-1a
  for (const char letter : text)
    hash = (hash ^ static_cast<unsigned char>(letter)) * 1099511628211U;
  return hash >> 17U;
}

TEST_P(BrokenScans, AreToldWithTheirCause) {
  const auto& [set, every] = GetParam();
  const std::size_t at = set.find('_');
  const auto tell = [&, every = every](RightScan right, std::uint64_t share) {
    std::optional<BrokenSet> broken;
    for (const Mistake& mistake : right.mistakes) {
      const std::uint64_t drawn = draw(set + label_of(right.scan.sequence.strategy) + mistake.name);
      if (drawn % (share * static_cast<std::uint64_t>(every)) != 0) continue;
      if (!broken && right.take) right.scan.frames = right.take();
      if (!broken) broken.emplace(set, right);
      broken->tell(mistake);
    }
  };
  if (at == std::string::npos) {
    if (!fs::exists(shared_data())) GTEST_SKIP() << shared_data() << " is not there";
    tell(real_scan(set), 1);
    return;
  }
  constexpr std::uint64_t one_in = 12;  // scenes and worlds: each mistake once or so
  const WorldScans world(set.substr(0, at), set.substr(at + 1));
  for (const Strategy& strategy : all_strategies()) tell(world.of(strategy), one_in);
}

std::vector<Part> all_sets() {
  std::vector<Part> all{
      {"skull"}, {"skull-alone"}, {"slmaster-mono"}, {"cpsd-plane"}, {"kamino-gamma"}};
  for (const char* scene : {"statue", "boxes", "sphere", "board"}) {
    for (const char* world : {"ideal", "bench", "harsh"}) {
      all.push_back({fmt::format("{}_{}", scene, world)});
    }
  }
  return all;
}

/// About a tenth of all mistakes, where it takes little time.
std::vector<Part> tenth() {
  return {{"skull", 8},       {"skull-alone", 8},   {"slmaster-mono", 20},
          {"cpsd-plane", 40}, {"kamino-gamma", 10}, {"statue_ideal", 3},
          {"boxes_bench", 4}, {"sphere_ideal", 3},  {"board_ideal", 3}};
}

std::string name_of_part(const testing::TestParamInfo<Part>& part) {
  std::string name = part.param.set;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Sets, BrokenScans, testing::ValuesIn(all_sets()), name_of_part);
INSTANTIATE_TEST_SUITE_P(Tenth, BrokenScans, testing::ValuesIn(tenth()), name_of_part);

}  // namespace slipstream::broken_table_test
