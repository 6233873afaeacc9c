#include "check/map_mistakes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/numbers.h"
#include "check/geometric_mistakes.h"

namespace slipstream {
namespace {

class MapMistakes {
 public:
  MapMistakes(const MapForm& form, const Scanner& scanner, Axis axis)
      : given_(form), scanner_(scanner), axis_(axis), length_(length(axis)) {
    add_units();
    add_origins();
    add_directions();
    add_periods();
    add_geometry();

    for (std::size_t i = 0; i < list.size(); ++i) list[i].mistake.rank = i;
  }

  std::vector<MapMistake> list{};

 private:
  [[nodiscard]] int length(Axis axis) const { return length_along(axis, scanner_.projector.size); }

  [[nodiscard]] bool has_periods() const { return given_.periods > 0; }

  /// Sets the mistake's scale and shift, which turn coordinates read as given into coordinates read
  /// as `form`.
  void read_as(const MapForm& form, int length, MapMistake& mistake) const {
    const auto slope_of = [](const MapForm& any, int pixels) {
      return any.backwards ? -span_of(any, pixels) : span_of(any, pixels);
    };

    const double slope = slope_of(form, length);
    mistake.scale = slope_of(given_, length_) / slope;
    mistake.shift = (origin_of(given_, length_) - origin_of(form, length)) / slope;
  }

  PossibleMistake& add(const MapForm& form, CauseKind kind, std::string likely) {
    std::vector<SettingChange> changes;
    if (name_of(form) != name_of(given_)) changes.push_back({"from", name_of(form)});
    if (form.origin != given_.origin) {
      changes.push_back({"origin", fmt::format("{:.6g}", form.origin.value_or(0))});
    }
    if (form.backwards != given_.backwards) {
      changes.push_back({"backwards", form.backwards ? "true" : "false"});
    }

    MapMistake& added = list.emplace_back();
    added.mistake.cause = {kind, std::move(likely)};
    added.mistake.remedies = {change_settings("try", std::move(changes))};
    read_as(form, length_, added);
    return added.mistake;
  }

  void add_unit(MapUnit unit, double periods, int family) {
    MapForm other = given_;
    other.unit = unit;
    other.periods = periods;
    if (other == given_) return;

    add(other, CauseKind::map_unit,
        fmt::format("a map of {}, not of {}", name_of(other), name_of(given_)))
        .family = family;
  }

  void add_units() {
    add_unit(MapUnit::coordinate, 0, 0);
    add_unit(MapUnit::pixels, 0, 0);

    if (has_periods()) {
      add_unit(MapUnit::phase, given_.periods, 0);
      add_unit(MapUnit::periods, given_.periods, 0);
      return;
    }

    constexpr int most = 64, phases = 1, counts = 2;
    for (int periods = 1; periods <= most; ++periods) {
      add_unit(MapUnit::phase, periods, phases);
      if (periods > 1) add_unit(MapUnit::periods, periods, counts);
    }
  }

  PossibleMistake& add_origin(double origin) {
    MapForm other = given_;
    other.origin = origin;
    return add(other, CauseKind::pattern_settings,
               fmt::format("a map whose value at the edge of the field is {:.6g}, not {:.6g}",
                           origin, origin_of(given_, length_)));
  }

  void add_origins() {
    const double origin = origin_of(given_, length_), span = span_of(given_, length_);
    add_origin(origin - span / 2);  // 0 in the middle of the field
    if (!has_periods()) return;

    // A phase that begins with -pi, and one that was anchored a few periods off.
    const double period = span / given_.periods;
    for (const double count : {-0.5, 1.0, -1.0, 0.5, 2.0, -2.0, 3.0, -3.0}) {
      add_origin(origin + count * period);
    }

    // A sine that was taken for a cosine.
    for (const double count : {-0.25, 0.25}) add_origin(origin + count * period).far_fetched = true;
  }

  void add_directions() {
    MapForm other = given_;
    other.backwards = !given_.backwards;
    const std::string likely =
        fmt::format("a map whose values {} across the field", other.backwards ? "fall" : "rise");
    add(other, CauseKind::pattern_settings, likely);

    // A phase that falls may also begin with 0.
    if (!other.backwards || !has_periods() || other.origin) return;
    other.origin = 0;
    add(other, CauseKind::pattern_settings, likely + " from 0");
  }

  void add_periods() {
    if (!has_periods()) return;

    constexpr int family = 3;
    const auto try_periods = [&](double periods) {
      MapForm other = given_;
      other.periods = periods;
      if (other == given_) return;
      add(other, CauseKind::pattern_settings,
          fmt::format("a phase of {:g} periods, not {:g}", periods, given_.periods))
          .family = family;
    };

    const int most = std::max(64, static_cast<int>(2 * given_.periods));
    for (int count = 1; count <= most; ++count) try_periods(count);

    const double half = given_.periods / 2;
    if (half != std::round(half)) try_periods(half);
  }

  void add_geometry() {
    Sequence sequence;
    sequence.axis = axis_;
    for (PossibleMistake& mistake : geometric_mistakes(scanner_, sequence)) {
      MapMistake& added = list.emplace_back();

      // Along the other axis the field has another number of pixels.
      if (mistake.sequence) read_as(given_, length(mistake.sequence->axis), added);
      added.mistake = std::move(mistake);
    }
  }

  const MapForm& given_;
  const Scanner& scanner_;
  Axis axis_;
  int length_;  ///< projector pixels along the axis
};

}  // namespace

std::vector<MapMistake> possible_map_mistakes(const MapForm& form, const Scanner& scanner,
                                              Axis axis) {
  return std::move(MapMistakes(form, scanner, axis).list);
}

}  // namespace slipstream
