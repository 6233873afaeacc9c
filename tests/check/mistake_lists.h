// The mistakes that a scan can have, by kind.
#pragma once

#include <numbers>
#include <set>

#include <fmt/format.h>

#include "base/statistics.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/unwrapping.h"
#include "tests/check/mistakes.h"
#include "tests/geometry/random_scanner.h"

namespace slipstream {

using Mistakes = std::vector<Mistake>;
using Words = std::vector<std::string>;

/// Level exceeded by a quarter of the lit pixels in their brightest frame.
inline double bright_level(const Scan& scan) {
  const Pictures pictures = pictures_of(scan);
  std::vector<double> brightest;
  for (std::size_t i = 0; i < pictures.front().pixel_count(); i += 17) {
    double least = 255, greatest = 0;
    for (const auto& picture : pictures) {
      least = std::min<double>(least, picture.begin()[i]);
      greatest = std::max<double>(greatest, picture.begin()[i]);
    }
    if (greatest - least > 22) brightest.push_back(greatest);
  }
  return quantile(brightest, 0.75);
}

inline auto light(double factor, double offset) {
  return [=](Scan& scan) {
    pixels(all_frames(scan.frames.count()),
           [=](double level, int, int) { return factor * level + offset; })(scan);
  };
}

/// The pictures of a camera of fewer bits, in 16-bit files.
inline auto in_16_bits(int bits) {
  return [bits](Scan& scan) {
    std::vector<Image<std::uint16_t>> wide;
    for (const Image<std::uint8_t>& picture : pictures_of(scan)) {
      wide.emplace_back(picture.size());
      std::transform(picture.begin(), picture.end(), wide.back().begin(), [&](std::uint8_t level) {
        return static_cast<std::uint16_t>(level << (bits - 8));
      });
    }
    scan.frames = FrameSet(std::move(wide), 16);
  };
}

/// Whether a shift of the origin moves the scene and contradicts nothing but its depths.
inline bool is_single_band(const Layout& layout) {
  return order_source(layout) == OrderSource::bands && layout.bands.size() == 1;
}

inline Mistakes mixed_frames(const Layout& layout) {
  const Words causes{"swapped", "reversed",    "rotated",    "slipped",   "order",      "origin",
                     "missing", "comes after", "come after", "other end", "interleaved"};
  Mistakes list;
  const std::vector<int> right = all_frames(layout.frames);
  std::set<std::vector<int>> known{right};
  const auto add = [&](std::string name, std::vector<int> order, std::string kind) {
    if (known.insert(order).second)
      list.push_back({std::move(name), taken_in_order(order), causes, kind});
  };
  const std::string kind = layout.code ? "order of code" : "order";
  const auto add_swapped = [&](int n, int m) {
    std::vector<int> order = right;
    std::swap(order[static_cast<std::size_t>(n)], order[static_cast<std::size_t>(m)]);
    add(fmt::format("frames {} and {} swapped", n, m), order, kind);
  };
  for (int n = 0; n + 1 < layout.frames; ++n) add_swapped(n, n + 1);
  for (int n = 0; n + 3 < layout.frames; n += 2) add_swapped(n, n + 3);
  add("all reversed", {right.rbegin(), right.rend()}, kind);
  for (const int places : {1, 2, layout.frames / 2, layout.frames - 2, layout.frames - 1}) {
    std::vector<int> order = right;
    std::rotate(order.begin(), order.begin() + places, order.end());
    add(fmt::format("all rotated by {}", places), order, is_single_band(layout) ? "slip" : kind);
  }
  // Each band's frames rotated by the same share of a period, or reversed.
  int common = 0;
  std::vector<StepRun> runs;
  for (const Band& band : layout.bands) {
    if (const auto run = step_run(band)) runs.push_back(*run);
  }
  for (const StepRun& run : runs) common = std::gcd(common, run.steps);
  for (int part = 0; part < common; ++part) {
    for (const bool backwards : {false, true}) {
      std::vector<int> order = right;
      for (const StepRun& run : runs) {
        const auto begin = order.begin() + run.first, end = begin + run.steps;
        if (backwards) std::reverse(begin, end);
        std::rotate(begin, begin + part * run.steps / common, end);
      }
      add(fmt::format("bands{} rotated by {}/{}", backwards ? " reversed," : "", part, common),
          order, "slip");
    }
  }
  return list;
}

inline Mistakes wrong_settings(const Strategy& strategy) {
  const StrategySettings& settings = strategy.settings();
  Mistakes list;
  const auto add = [&](const std::string& name, const SettingValue& value, Words causes,
                       std::string kind) {
    StrategySettings wrong = settings;
    wrong[name] = value;
    try {
      const Strategy made = make_strategy(strategy.name(), wrong);
      if (made.layout().frames != strategy.layout().frames) return;
      list.push_back({fmt::format("{} {}", name, value.text()),
                      [made](Scan& scan) { scan.sequence.strategy = made; }, std::move(causes),
                      std::move(kind)});
    } catch (const Error&) {
      return;  // the strategy has no such setting
    }
  };
  const double origin = settings.contains("origin") ? settings.at("origin").number() : 0;
  const std::vector<double> shifts =
      is_single_band(strategy.layout())
          ? std::vector<double>{2.0944, 3.1416}
          : std::vector<double>{0.3, 0.5, 1, 1.5708, 2.0944, 3.1416, -0.8};
  for (const double off : shifts) add("origin", origin + off, {"origin", "rotated"}, "origin");
  add("backwards", !settings.contains("backwards"), {"direction", "reversed", "origin", "swapped"},
      "origin");
  const Words of_code{"plain", "Gray", "other end", "reversed", "base", "code"};
  add("plain", !settings.contains("plain"), of_code, "settings of code");
  add("least_first", !settings.contains("least_first"), of_code, "settings of code");
  if (settings.contains("base")) {
    add("base", 3 - settings.at("base").number(), of_code, "settings of code");
  }
  for (const std::string name : {"high", "low", "periods"}) {
    if (!settings.contains(name)) continue;
    std::vector<double> periods;
    settings.at(name).read(periods);
    for (std::size_t i = 0; i < periods.size(); ++i) {
      for (const double factor : {0.5, 0.9, 1.1, 2.0}) {
        std::vector<double> wrong = periods;
        wrong[i] = std::round(factor * periods[i]);
        if (wrong != periods && wrong[i] > 0) add(name, wrong, {"periods"}, "periods");
      }
    }
    // Counted in pixels of the other axis.
    for (double& count : periods) count *= 1.6;
    add(name, periods, {"periods"}, "lengths along y");
  }
  if (settings.contains("stripes")) {
    add("stripes", 0.625 * settings.at("stripes").number(), {"stripes"}, "lengths along y");
  }
  return list;
}

inline Mistakes spoilt_frames(int count) {
  Mistakes list;
  const auto add = [&](std::string kind, std::string name, std::function<void(Scan&)> make,
                       Words causes) {
    list.push_back({std::move(name), std::move(make), std::move(causes), std::move(kind)});
  };
  const int last = count - 1;
  const auto all = all_frames(count);
  for (const int n : {1, last / 2}) {
    add("lost frames", fmt::format("frame {} saved twice", n), copied(n, n + 1), {"twice"});
    add("lost frames", fmt::format("frame {} half stale", n), copied(n - 1, n, 0.5), {"lost"});
  }
  for (const int n : {0, last}) {
    add("lost frames", fmt::format("frame {} black", n),
        pixels({n}, [](double, int, int) { return 1; }), {"black", "missing"});
    add("light", fmt::format("frame {} brighter by 5 percent", n),
        pixels({n}, [](double level, int, int) { return 1.05 * level; }), {"flickers"});
  }
  add("lost frames", "last frame half lost",
      [last](Scan& scan) {
        const int half = scan.frames.size().height / 2;
        pixels({last}, [half](double level, int, int row) { return row < half ? level : 0; })(scan);
      },
      {"lost"});
  add("light", "a tenth of the light", light(0.1, 0), {"too little light"});
  add("light", "all black", light(0, 0), {"no pattern"});
  add("light", "clipped below the largest grey level",
      [all](Scan& scan) {
        const double top = 0.8 * bright_level(scan);
        pixels(all, [top](double level, int, int) { return std::min(level, top); })(scan);
      },
      {"clipped", "clips"});
  add("light", "far too bright", light(4, 0), {"clips", "too much light"});
  add("light", "room light", light(0.4, 150), {"ambient light"});
  for (const int bits : {10, 12, 14}) {
    add("pixels", fmt::format("{} bits in 16", bits), in_16_bits(bits),
        {fmt::format("{} bits", bits)});
  }
  for (const double share : {0.8, 0.5}) {
    add("pixels", fmt::format("Bayer mosaic, {}", share),
        pixels(all,
               [share](double level, int column, int row) {
                 const bool green = (column + row) % 2 == 1;
                 return green ? level : (row % 2 == 0 ? 1 : 0.9) * share * level;
               }),
        {"colour camera"});
  }
  return list;
}

inline Mistakes wrong_scanners() {
  Mistakes list;
  const auto add = [&](std::string kind, std::string name, std::function<void(Scanner&)> make,
                       Words causes) {
    list.push_back(
        {std::move(name), with_scanner(std::move(make)), std::move(causes), std::move(kind)});
  };
  add("scanner file", "metres", [](Scanner& s) { s.translation /= 1000; }, {"metres"});
  for (const double mm : {10.0, 25.4}) {
    for (const bool known : {false, true}) {
      add("scale", fmt::format("units of {} mm{}", mm, known ? " and depths" : ""),
          [=](Scanner& s) {
            s.translation /= mm;
            if (s.calibrated_depths && known) {
              s.calibrated_depths = {s.calibrated_depths->nearest / mm,
                                     s.calibrated_depths->farthest / mm};
            } else {
              s.calibrated_depths.reset();
            }
          },
          {"centimetres or inches"});
    }
  }
  add("scanner file", "inverted",
      [](Scanner& s) {
        s.rotation.transposeInPlace();
        s.translation = -s.rotation * s.translation;
      },
      {"from the projector to the camera"});
  add("scanner file", "rotation inverted", [](Scanner& s) { s.rotation.transposeInPlace(); },
      {"rotation is inverted"});
  add("scanner file", "no rotation", [](Scanner& s) { s.rotation.setIdentity(); },
      {"rotation", "another rig"});
  add("scanner file", "translation negated", [](Scanner& s) { s.translation *= -1; },
      {"wrong sign"});
  add("scanner file", "devices swapped",
      [](Scanner& s) { std::swap(s.camera.intrinsic, s.projector.intrinsic); },
      {"swapped", "of the other device"});
  for (const unsigned seed : {5U, 6U}) {
    add("scanner file", fmt::format("another rig, {}", seed),
        [seed](Scanner& s) {
          const Scanner other = random_scanner(seed, 0, s.camera.size);
          s.camera = other.camera;
          s.rotation = other.rotation;
          s.translation = other.translation;
          if (s.calibrated_depths) {
            const double depth = working_volume(other).centre.z();
            s.calibrated_depths = {0.75 * depth, 1.25 * depth};
          }
        },
        {"another rig", "another size", "calibration boards"});
  }
  add("scanner file", "half the projector's columns",
      [](Scanner& s) { s.projector.size.width /= 2; }, {"another size", "projector pictures"});
  return list;
}

inline Mistakes turned_pictures() {
  Mistakes list;
  const auto add = [&](std::string name, auto from, double scale, Words causes) {
    list.push_back({std::move(name), resampled(from, scale), std::move(causes), "pictures"});
  };
  add("mirrored", [](double x, double y, Size size) { return std::pair(size.width - 1 - x, y); }, 1,
      {"mirrored left to right", "upside down"});
  add("upside down",
      [](double x, double y, Size size) {
        return std::pair(size.width - 1 - x, size.height - 1 - y);
      },
      1, {"upside down", "mirrored"});
  add("halved", [](double x, double y, Size) { return std::pair(2 * x, 2 * y); }, 0.5,
      {"another size", "twice as large"});
  add("doubled", [](double x, double y, Size) { return std::pair(x / 2, y / 2); }, 2,
      {"another size", "half as large"});
  add("cropped",
      [](double x, double y, Size size) {
        return std::pair(x + 0.4 * size.width, y + 0.3 * size.height);
      },
      0.6, {"cropped", "another size"});
  list.push_back({"other axis",
                  [](Scan& scan) { scan.sequence.axis = across(scan.sequence.axis); },
                  {"vary along"},
                  "pictures"});
  return list;
}

/// Everything that can be done to a taken scan.
inline Mistakes mistakes_of(const Scan& right) {
  const Strategy& strategy = right.sequence.strategy;
  Mistakes all = mixed_frames(strategy.layout());
  const auto add = [&all](Mistakes more) {
    std::move(more.begin(), more.end(), std::back_inserter(all));
  };
  add(wrong_settings(strategy));
  add(spoilt_frames(strategy.layout().frames));
  if (right.scanner && has_geometry(*right.scanner)) {
    add(wrong_scanners());
    add(turned_pictures());
  }
  return all;
}

}  // namespace slipstream
