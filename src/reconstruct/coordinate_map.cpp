#include "reconstruct/coordinate_map.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/numbers.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "reconstruct/points.h"

namespace slipstream {
namespace {

/// Value at the end of the projector's field.
double field_of(const std::string& form, int length) {
  if (form == "coordinate") return 1;
  if (form == "pixels") return length;

  const bool of_phase = form.starts_with("phase:");
  const double periods = of_phase ? number_in<double>(form.substr(6)).value_or(0) : 0;
  throw_if(!(periods > 0 && std::isfinite(periods)), "map '{}': expected {}", form, map_forms);
  return two_pi * periods;
}

/// Whether the values fill one turn from 0 or -pi, rad.
bool is_wrapped(double least, double largest) {
  constexpr double nearly = 0.95, rounding = 1e-3;
  const bool in_turn = (least >= 0 && largest <= two_pi + rounding) ||
                       (least >= -two_pi / 2 - rounding && largest <= two_pi / 2 + rounding);
  return in_turn && largest - least > nearly * two_pi;
}

void require_possible(const Image<double>& map, const std::string& form, double field, int length) {
  std::vector<double> values = finite_values(map);
  throw_if(values.empty(), "has no valid value");

  const auto [least, largest] = std::ranges::minmax_element(values);
  throw_if(form.starts_with("phase") && field > two_pi && is_wrapped(*least, *largest),
           "the phase is wrapped, {:.4g} to {:.4g} rad; unwrap it, e.g. with `unwrap()`", *least,
           *largest);

  constexpr double outliers = 0.02, margin = 0.05;  // of the values; of the field
  const double low = quantile(values, outliers), high = quantile(values, 1 - outliers);
  throw_if(low < -margin * field || high > (1 + margin) * field,
           "values from {:.4g} to {:.4g} exceed the projector, 0 to {:.6g} for {}; expected {}",
           low, high, field, form, map_forms);

  throw_if((high - low) / field * length < 1,
           "values from {:.4g} to {:.4g} lie in one projector pixel of {}; expected {}", low, high,
           form, map_forms);
}

}  // namespace

Image<double> coordinates_of_map(Image<double> map, const std::string& form, int length) {
  const double field = field_of(form, length);
  require_possible(map, form, field, length);
  for (double& value : map) value /= field;
  return map;
}

Cloud cloud_of_coordinates(Image<double> coordinates, const EngineSetup& setup,
                           const Image<float>& modulation) {
  // 1. Check that the sizes match.
  require_valid(setup);
  const Size camera = setup.scanner.camera.size;
  throw_if(coordinates.size() != camera, "the map is {}, the scanner's camera has {}",
           text_of(coordinates.size()), text_of(camera));
  throw_if(!modulation.empty() && modulation.size() != camera,
           "the modulation is {}, the scanner's camera has {}", text_of(modulation.size()),
           text_of(camera));

  // 2. Leave out pixels that are too dark, and those without a coordinate.
  for (std::size_t i = 0; i < modulation.pixel_count(); ++i) {
    if (!(modulation.begin()[i] >= setup.settings.minimum_modulation)) coordinates.begin()[i] = nan;
  }

  Image<Validity> validity(camera);
  std::ranges::transform(coordinates, validity.begin(), [](double y) {
    return std::isfinite(y) ? Validity::valid : Validity::too_dark;
  });

  // 3. Triangulate and clean. A map has no grey levels, so all points are equally bright.
  const Triangulator triangulate(setup.scanner, setup.sequence.axis, PointMethod::form3);
  Cloud cloud;
  convert(triangulated(coordinates, std::move(validity), triangulate, setup), cloud);

  std::ranges::fill(cloud.intensity, 255.F);
  Cleaner(setup.settings.clean)(cloud, modulation.empty() ? nullptr : &modulation);

  return cloud;
}

}  // namespace slipstream
