#include "app/clean_flags.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "app/flag_group.h"
#include "slipstream/base/error.h"

namespace slipstream::app {
namespace {

std::optional<PointBox> box_of(const std::vector<double>& numbers) {
  if (numbers.empty()) return std::nullopt;
  if (numbers.size() != 6) {
    throw Error(
        fmt::format("--box takes 6 numbers, mm, not {}: -50,-50,600,50,50,800", numbers.size()));
  }
  PointBox box;
  std::copy_n(numbers.begin(), 3, box.least.begin());
  std::copy_n(numbers.begin() + 3, 3, box.largest.begin());
  return box;
}

std::vector<PictureCorner> outline_of(const std::vector<double>& numbers) {
  if (numbers.size() % 2 != 0 || numbers.size() == 2) {
    throw Error(fmt::format(
        "--outline takes column and row of two corners or more, not {} numbers: 100,80,500,400",
        numbers.size()));
  }
  std::vector<PictureCorner> corners;
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    corners.push_back({numbers[i], numbers[i + 1]});
  }
  return corners;
}

}  // namespace

void add_clean_flags(CLI::App& subcommand, CleanFlags& flags) {
  const FlagGroup group{subcommand, "Which points stay, and how"};
  group.add("--raw", flags.raw, "leave all points in: no filter but those asked for");
  group.add(
      "--max-sigma", flags.largest_sigma,
      "largest standard deviation of depth, as the noise predicts it, mm; three hundredths of "
      "the depth where not given");
  group.add("--min-component", flags.smallest_component,
            "fewest pixels of a connected piece; 200 where not given");
  group.add("--box", flags.box, "only points in it, mm: least x,y,z and largest x,y,z")
      ->delimiter(',');
  group
      .add("--outline", flags.outline,
           "only camera pixels in it, as x,y,x,y: two corners of a rectangle, or a polygon")
      ->delimiter(',');
  group.add("--fill", flags.widest_gap, "widest gap of a surface that gets points, pixels");
  group.add("--smooth", flags.smoothing,
            "half the window over which points move to their surface, edges kept, pixels");
}

void set_clean(ReconstructSettings& settings, const CleanFlags& flags) {
  CleanSettings& clean = settings.clean;
  clean = flags.raw ? CleanSettings::none() : CleanSettings();
  if (flags.raw) {
    settings.nearest = settings.nearest.value_or(0);
    settings.farthest = settings.farthest.value_or(std::numeric_limits<double>::infinity());
  }
  if (flags.largest_sigma) clean.largest_sigma = flags.largest_sigma;
  clean.smallest_component = flags.smallest_component.value_or(clean.smallest_component);
  clean.box = box_of(flags.box);
  clean.outline = outline_of(flags.outline);
  clean.widest_gap = flags.widest_gap;
  clean.smoothing = flags.smoothing;
  require_valid(clean);
}

nlohmann::json json_of(const ValidityCounts& counts) {
  nlohmann::json named = nlohmann::json::object();
  for (std::size_t i = 0; i < validity_count; ++i) {
    named[std::string(name_of(static_cast<Validity>(i)))] = counts[i];
  }
  return named;
}

}  // namespace slipstream::app
