#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/statistics.h"
#include "simulate/seen_scene.h"
#include "slipstream/check.h"
#include "slipstream/engine.h"
#include "slipstream/virtual_world.h"
#include "tests/check/random_scans.h"

namespace slipstream {

/// Upright and oblique boxes of 1 to 3 camera pixels in front of a wall or of nothing.
inline Scene wires(const Scanner& scanner, double pixels, bool with_wall) {
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

/// A right scan and the truth about it.
struct RightScan {
  std::string name, strategy;
  VirtualWorld world;
  Scan scan;
  std::vector<VirtualScan> truths;  ///< of each camera
};

/// Why a warning is right, from the truth of one camera and from its cloud; empty if it is not.
inline std::string true_cause(const Scan& scan, const VirtualScan& truth,
                              const Photometry& photometry, const std::vector<Finding>& found) {
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

inline std::string true_cause(const RightScan& right, const std::vector<Finding>& found) {
  std::string cause = true_cause(right.scan, right.truths[0], right.world.photometry, found);
  if (!cause.empty() || right.scan.further_cameras.empty()) return cause;
  return true_cause(right.scan.further_cameras[0], right.truths[1], right.world.photometry, found);
}

/// One scan of the set [first, end); `end`: the share over the set, after its scans.
struct Member {
  int first = 0, end = 0, number = 0;

  [[nodiscard]] bool is_share() const { return number == end; }
};

inline void PrintTo(const Member& member, std::ostream* out) {
  *out << "number " << member.number;
}

/// The set [first, end), and its share.
inline std::vector<Member> set_of(int first, int end) {
  std::vector<Member> set;
  for (int number = first; number <= end; ++number) set.push_back({first, end, number});
  return set;
}

inline std::string named(const testing::TestParamInfo<Member>& member) {
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

}  // namespace slipstream
