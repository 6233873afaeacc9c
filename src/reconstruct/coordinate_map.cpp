#include "reconstruct/coordinate_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "reconstruct/contrast.h"
#include "reconstruct/points.h"

namespace slipstream {

Cloud cloud_of_coordinates(Image<double> coordinates, const EngineSetup& setup,
                           const Image<float>& modulation, Maps* corrected) {
  // 1. Check that the sizes match.
  require_valid(setup);
  const Size camera = setup.scanner.camera.size;
  throw_if(coordinates.size() != camera, "the map is {}, the scanner's camera has {}",
           text_of(coordinates.size()), text_of(camera));
  throw_if(setup.settings.correct_contrast && modulation.empty(),
           "`correct_contrast` needs the map's modulation");
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

  // 3. Triangulate, correct and clean. A map has no grey levels, so all points are equally bright.
  const Triangulator triangulate(setup.scanner, setup.sequence.axis, PointMethod::form3);
  Cloud cloud;
  convert(triangulated(coordinates, std::move(validity), triangulate, setup), cloud);
  Maps maps;
  maps.coordinate = converted<float>(coordinates);
  if (setup.settings.correct_contrast) {
    maps.modulation = modulation;
    correct_contrast(setup, cloud, maps);
    maps.modulation = {};
  }
  if (corrected != nullptr) *corrected = std::move(maps);

  std::ranges::fill(cloud.intensity, 255.F);
  Cleaner(setup.settings.clean)(cloud, modulation.empty() ? nullptr : &modulation);

  return cloud;
}

}  // namespace slipstream
