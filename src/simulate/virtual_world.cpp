#include "slipstream/virtual_world.h"

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/ranges.h>

#include "base/numbers.h"
#include "codes/predicted_variance.h"
#include "response/response_fit.h"
#include "simulate/virtual_files.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"

namespace slipstream {
namespace {

Photometry ideal() {
  return {.ambient = 5, .noise_variance = 1.55};
}

Photometry bench() {
  return {.ambient = 5,
          .rays = 16,
          // Optics, light and motion.
          .physics = {.projector_pixels = true,
                      .projector = {.blur = 0.6, .defocus = 4},
                      .camera = {.blur = 0.5, .defocus = 2},
                      .vignetting = 0.2,
                      .fall_off = true,
                      .ambient_gradient = 0.3,
                      .motion_blur = true,
                      // Sensor.
                      .full_well = 10000,
                      .read_noise = 3,
                      .row_noise = 0.05,
                      .dark_spread = 0.05,
                      .sensitivity_spread = 0.005}};
}

Photometry harsh() {
  return {.ambient = 15,
          .response = PowerLaw{2.2},
          .rays = 16,
          // Optics.
          .physics = {.projector_pixels = true,
                      .projector = {.blur = 1, .defocus = 10},
                      .camera = {.blur = 0.9, .defocus = 6},
                      .vignetting = 0.5,
                      .fall_off = true,
                      // Surfaces, ambient light and motion.
                      .gloss = 0.4,
                      .translucency = 1,
                      .bounces = 32,
                      .ambient_gradient = 1,
                      .flicker = 0.01,
                      .motion_blur = true,
                      .rolling_shutter = true,
                      .lens_residue = 0.1,
                      // Sensor.
                      .full_well = 5000,
                      .read_noise = 15,
                      .row_noise = 0.3,
                      .dark_spread = 0.5,
                      .sensitivity_spread = 0.01,
                      // Calibration boards.
                      .board_bend = 0.3,
                      .board_stretch = 0.002}};
}

/// The harsh world, seen by a camera that makes pictures for people.
Photometry with_all_effects() {
  Photometry photometry = harsh();
  Physics& physics = photometry.physics;
  physics.auto_exposure = 0.05;

  // A picture of sRGB is what a display of this response turns into light.
  const ResponseCurve display = srgb_curve();
  physics.tone = response_curve(display.light, display.values);

  physics.sharpening = 0.5;
  physics.jpeg_quality = 90;
  return photometry;
}

struct Effect {
  std::string_view name;
  void (*take)(Photometry& to, const Photometry& from);
};

template <auto... members>
void take(Photometry& to, const Photometry& from) {
  ((to.physics.*members = from.physics.*members), ...);
}

constexpr std::array effects{
    Effect{"projector-pixels", take<&Physics::projector_pixels>},
    Effect{"projector-blur", take<&Physics::projector>},
    Effect{"camera-blur", take<&Physics::camera>},
    Effect{"wide-pixels", [](Photometry& to, const Photometry& from) { to.rays = from.rays; }},
    Effect{"vignetting", take<&Physics::vignetting>}, Effect{"fall-off", take<&Physics::fall_off>},
    Effect{"gloss", take<&Physics::gloss>}, Effect{"translucency", take<&Physics::translucency>},
    Effect{"interreflection", take<&Physics::bounces>},
    Effect{"ambient-gradient", take<&Physics::ambient_gradient>},
    Effect{"flicker", take<&Physics::flicker>}, Effect{"motion-blur", take<&Physics::motion_blur>},
    Effect{"rolling-shutter", take<&Physics::rolling_shutter>},
    Effect{"lens-residue", take<&Physics::lens_residue>},
    // Shot, read and row noise replace the constant noise.
    Effect{"sensor-noise",
           [](Photometry& to, const Photometry& from) {
             take<&Physics::full_well, &Physics::read_noise, &Physics::row_noise>(to, from);
             to.noise_variance = from.noise_variance;
           }},
    Effect{"fixed-pattern", take<&Physics::dark_spread, &Physics::sensitivity_spread>},
    Effect{"auto-exposure", take<&Physics::auto_exposure>},
    Effect{"tone-curve", take<&Physics::tone>}, Effect{"sharpening", take<&Physics::sharpening>},
    Effect{"jpeg", take<&Physics::jpeg_quality>},
    Effect{"response", [](Photometry& to, const Photometry& from) { to.response = from.response; }},
    Effect{"bent-board", take<&Physics::board_bend>},
    Effect{"stretched-board", take<&Physics::board_stretch>}};

struct World {
  std::string_view name;
  Photometry (*photometry)();
};

constexpr std::array worlds{World{"ideal", ideal}, World{"bench", bench}, World{"harsh", harsh}};

template <class Entries>
std::vector<std::string_view> names_of(const Entries& entries) {
  std::vector<std::string_view> names;
  for (const auto& entry : entries) names.push_back(entry.name);
  return names;
}

template <class Entries>
const auto& entry_named(const Entries& entries, std::string_view name, std::string_view kind) {
  for (const auto& entry : entries) {
    if (entry.name == name) return entry;
  }

  const std::vector<std::string_view> names = names_of(entries);
  throw Error(fmt::format("{} '{}' is not known; expected one of: {}{}", kind, name,
                          fmt::join(names, ", "), did_you_mean(name, names)));
}

}  // namespace

Scanner as_calibrated(const VirtualWorld& world) {
  Scanner scanner = world.scanner;
  PhotometricCalibration& known = scanner.photometry;
  const Photometry& light = world.photometry;
  const Physics& physics = light.physics;

  // Rounding to the camera's grey levels adds noise.
  const double step = light.bits ? 255.0 / ((1 << *light.bits) - 1) : 0;
  double variance = light.noise_variance + quantisation_variance * step * step;

  known.ambient = light.ambient;
  known.noise_gain = 0;

  // Read noise, and shot noise at half of full scale.
  if (physics.full_well > 0) {
    known.noise_gain = 255 / physics.full_well;
    variance += std::pow(known.noise_gain * physics.read_noise, 2) + known.noise_gain * 127.5;
  }
  variance += physics.row_noise * physics.row_noise;
  known.noise_variance = variance > 0 ? std::optional(variance) : std::nullopt;

  // A camera's processing leaves no noise that a gain describes, and lifts dark levels.
  const bool bent = !is_linear(physics.tone);
  if (bent || physics.sharpening > 0 || physics.jpeg_quality > 0) {
    known.noise_variance.reset();
    known.noise_gain = 0;
  }
  if (bent) known.ambient = 255 * light_at(physics.tone, light.ambient / 255);

  const double depth = working_volume(scanner).centre.z();
  scanner.calibrated_depths = {0.75 * depth, 1.25 * depth};

  return scanner;
}

std::vector<std::string_view> world_names() {
  return names_of(worlds);
}

std::vector<std::string_view> effect_names() {
  return names_of(effects);
}

Photometry photometry_named(std::string_view text) {
  Photometry photometry = entry_named(worlds, take_until(text, ','), "world").photometry();

  // Then the effects: each at its full strength or, with no-, as in the ideal world.
  while (!text.empty()) {
    std::string_view name = take_until(text, ',');
    const bool out = name.starts_with("no-");
    if (out) name.remove_prefix(3);

    entry_named(effects, name, "effect").take(photometry, out ? ideal() : with_all_effects());
  }

  return photometry;
}

Scanner second_scanner(const Scanner& first, int number) {
  constexpr double past_the_projector = 1.6, above = 0.6;           // baselines
  const int level = (number - 1) / 2 * (number % 2 == 0 ? 1 : -1);  // 0, -1, 1, -2 and so on
  const Eigen::Vector3d centre =
      past_the_projector * projector_centre(first) +
      above * level * projector_centre(first).norm() * Eigen::Vector3d::UnitY();

  // From the first camera's frame to the second's.
  const Eigen::Matrix3d turn = looking_along(working_volume(first).centre - centre);

  Scanner second = first;
  second.rotation = first.rotation * turn.transpose();
  second.translation = in_projector_frame(first, centre);
  return second;
}

Scene seen_from_second(const Scene& scene, const Scanner& first, const Scanner& second) {
  Eigen::Isometry3d to_second = Eigen::Isometry3d::Identity();
  to_second.linear() = second.rotation.transpose() * first.rotation;
  to_second.translation() = second.rotation.transpose() * (first.translation - second.translation);

  Scene seen = scene;
  for (Body& body : seen) {
    body.pose = to_second * body.pose;
    body.motion = moved_by(to_second, body.motion);
  }

  return seen;
}

VirtualWorld seen_from_second(const VirtualWorld& first, int number) {
  VirtualWorld second{.scanner = second_scanner(first.scanner, number),
                      .photometry = first.photometry};
  second.scene = seen_from_second(first.scene, first.scanner, second.scanner);
  second.photometry.seed = ~first.photometry.seed + static_cast<std::uint64_t>(number - 2);
  return second;
}

#ifndef SLIPSTREAM_IO
Mesh read_mesh(const std::filesystem::path& path) {
  throw Error(fmt::format("{}: this build reads no files (SLIPSTREAM_IO is off)", path.string()));
}
#endif

VirtualWorld virtual_world(const WorldSettings& settings) {
  require_in_range(settings);
  VirtualWorld world{
      .scanner = settings.scanner ? *settings.scanner : example_scanner(settings.camera),
      .photometry = photometry_named(settings.world)};

  Photometry& photometry = world.photometry;
  photometry.ambient = settings.ambient.value_or(photometry.ambient);
  photometry.response = settings.response.value_or(photometry.response);
  photometry.rays = settings.rays.value_or(photometry.rays);
  photometry.bits = settings.bits;
  photometry.seed = settings.seed;

  // A given noise replaces the sensor's own; the differences from pixel to pixel stay.
  if (settings.noise_variance) {
    photometry.noise_variance = *settings.noise_variance;
    photometry.physics.full_well = photometry.physics.row_noise = 0;
  }

  world.scene = settings.mesh
                    ? scene_with_mesh(read_mesh(*settings.mesh), world.scanner, settings.mesh_size)
                    : scene_named(settings.scene, world.scanner);

  // All bodies that are not fixed move together, on top of their own motion.
  Motion motion = settings.motion;
  motion.centre = working_volume(world.scanner).centre;
  for (Body& body : world.scene) {
    if (settings.reflectivity) body.texture = uniform_texture(*settings.reflectivity);
    body.pose.pretranslate(settings.shift);
    const Eigen::Isometry3d shift(Eigen::Translation3d(settings.shift));
    if (!body.fixed) body.motion = carried_by(motion, moved_by(shift, body.motion));
  }

  return world;
}

}  // namespace slipstream
