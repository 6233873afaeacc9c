#include "app/source_flags.h"

#include <numbers>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/flag_group.h"
#include "app/scan_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/base/size.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/virtual_files.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream::app {
namespace {

void add_scene_flags(CLI::App& command, VirtualFlags& flags) {
  const FlagGroup group{command, "Scene"};
  group.add("--scene", flags.scene, fmt::format("{}", fmt::join(scene_names(), ", ")));
  group.add_file("--mesh", flags.mesh, "a PLY or OBJ mesh (Y up, facing +Z) instead of a scene");
  group.add("--mesh-size", flags.mesh_size, "its largest side, mm; fills the view where 0");
  group.add("--reflectivity", flags.reflectivity, "alpha of every surface, 0 to 1");
  group.add("--shift", flags.shift, "where it stands, off its own place: X Y Z, mm")->expected(3);
  group.add("--move", flags.motion, "how it moves from frame to frame: X Y Z, mm")
      ->expected(3)
      ->default_str(fmt::format("{}", fmt::join(flags.idle_motion, " ")));
  group.add("--turn", flags.turn,
            "how it turns about its upright axis from frame to frame: degrees");
  group
      .add("--vibrate", flags.vibration,
           "how it swings along the view: MM each way, FRAMES a period")
      ->expected(2);
  group
      .add("--breathe", flags.breathing,
           "how it grows and shrinks: SHARE each way, FRAMES a period")
      ->expected(2);
}

void add_device_flags(CLI::App& command, VirtualFlags& flags) {
  const FlagGroup group{command, "Devices"};
  group
      .add_read<>(
          "--camera",
          [&flags](const std::string& text) { flags.camera = size_from(text, "--camera"); },
          "size of the example's camera")
      ->default_str("640x480");
  group.add("--world", flags.world,
            fmt::format("{}; with changes, as bench,gloss or harsh,no-flicker: {}",
                        fmt::join(world_names(), ", "), fmt::join(effect_names(), ", ")));
  group.add("--virtual-ambient", flags.ambient, "ambient light beta, grey levels of 255");
  group.add_read<>(
      "--virtual-gamma",
      [&flags](const std::string& text) {
        flags.response = response_named(text, "--virtual-gamma");
      },
      "response of projector and camera: gamma, srgb, logistic:SLOPE:CENTRE, or a file that "
      "holds one");
  group.add("--virtual-noise", flags.noise_variance,
            "sigma_w^2, grey levels^2 of 255, in place of the world's noise");
  group.add("--camera-bits", flags.bits, "of the camera, 8 to 16");
  group.add("--seed", flags.seed, "of the noise");
  group.add("--rays", flags.rays,
            "rays of each pixel at edges, 1 to 256: more put them truer and take longer");
}

/// Of the file that --scanner names, else the example with a camera of that size.
Scanner virtual_scanner(const VirtualFlags& flags) {
  if (flags.scanner && flags.camera) {
    throw Error(
        "--scanner and --camera exclude each other; the scanner file says the camera's size");
  }
  if (!flags.scanner) {
    return example_scanner(flags.camera.value_or(Size{640, 480}));
  }
  Scanner scanner = read_scanner(*flags.scanner);
  require_valid(scanner);
  return scanner;
}

Photometry virtual_photometry(const VirtualFlags& flags) {
  Photometry photometry = photometry_named(flags.world);
  photometry.ambient = flags.ambient.value_or(photometry.ambient);
  photometry.response = flags.response.value_or(photometry.response);
  photometry.rays = flags.rays.value_or(photometry.rays);
  photometry.bits = flags.bits;
  photometry.seed = flags.seed;
  if (flags.noise_variance) {
    photometry.noise_variance = *flags.noise_variance;
    photometry.physics.full_well = photometry.physics.row_noise = 0;
  }
  return photometry;
}

/// Amplitude and period of a flag.
Swing<double> swing_from(const std::vector<double>& flag, std::string_view name, double most) {
  if (flag.empty()) return {};
  const Swing<double> swing{flag[0], flag[1]};
  if (!(swing.amplitude >= 0 && swing.amplitude < most && swing.period > 0)) {
    throw Error(fmt::format("{} {} {} is out of range; 0 to less than {}, and frames above 0", name,
                            flag[0], flag[1], most));
  }
  return swing;
}

Motion motion_from(const VirtualFlags& flags, const Eigen::Vector3d& centre) {
  Motion motion{.centre = centre};
  const bool idle =
      flags.motion.empty() && flags.turn == 0 && flags.vibration.empty() && flags.breathing.empty();
  if (idle) motion.step = flags.idle_motion;
  if (!flags.motion.empty()) motion.step = Eigen::Vector3d(flags.motion.data());
  motion.turn = Eigen::Vector3d(0, flags.turn * std::numbers::pi / 180, 0);
  const Swing<double> vibration = swing_from(flags.vibration, "--vibrate", 1000);
  motion.vibration = {{0, 0, vibration.amplitude}, vibration.period};
  motion.breathing = swing_from(flags.breathing, "--breathe", 1);
  return motion;
}

Scene virtual_scene(const VirtualFlags& flags, const Scanner& scanner) {
  Scene scene = flags.mesh ? scene_with_mesh(read_mesh(*flags.mesh), scanner, flags.mesh_size)
                           : scene_named(flags.scene, scanner);
  if (flags.reflectivity && !(*flags.reflectivity >= 0 && *flags.reflectivity <= 1)) {
    throw Error(fmt::format("--reflectivity {} is out of range; 0 to 1", *flags.reflectivity));
  }
  const Motion motion = motion_from(flags, working_volume(scanner).centre);
  for (Body& body : scene) {
    if (flags.reflectivity) body.texture = uniform_texture(*flags.reflectivity);
    if (!flags.shift.empty()) body.pose.pretranslate(Eigen::Vector3d(flags.shift.data()));
    if (!body.fixed) body.motion = motion;
  }
  return scene;
}

}  // namespace

void add_virtual_flags(CLI::App& command, VirtualFlags& flags) {
  add_scene_flags(command, flags);
  add_device_flags(command, flags);
}

VirtualWorld world_from(const VirtualFlags& flags) {
  VirtualWorld world{.scanner = virtual_scanner(flags), .photometry = virtual_photometry(flags)};
  world.scene = virtual_scene(flags, world.scanner);
  return world;
}

Sequence sequence_for(const SequenceChanges& changes, const Scanner& scanner) {
  const Size projector = scanner.projector.size;
  const Sequence sequence = default_sequence(projector, changes);
  if (sequence.projector != projector) {
    throw Error(fmt::format("--projector {} is not that of the scanner, {}",
                            text_of(sequence.projector), text_of(projector)));
  }
  return sequence;
}

void add_camera_flags(CLI::App& command, CameraSettings& settings) {
  const FlagGroup group{command, "Camera"};
  group.add_read<double>(
      "--exposure", [&settings](double ms) { settings.exposure = ms / 1e3; }, "of each frame, ms");
  group.add("--gain", settings.gain, "in the camera's unit, mostly dB");
  group.add_read<>(
      "--region",
      [&settings](const std::string& text) {
        settings.region = rectangle_of_text(text);
        if (settings.region) return;
        throw Error(fmt::format(
            "--region '{}' is no region; give width x height + x + y, as 640x480+16+8", text));
      },
      "part of the sensor, width x height + x + y, as 640x480+16+8; for v4l2 the size");
  group.add_named("--pixel-format", settings.pixel_format, pixel_format_named,
                  name_of(settings.pixel_format),
                  "Mono8, Mono10, Mono12, Mono16, or packed: Mono10p, Mono12p, Mono10Packed, "
                  "Mono12Packed; RGB8: three patterns to a picture in colour");
  group.add("--trigger", settings.trigger,
            "the camera's input that starts each frame, as Line1; runs freely without");
  group.add("--packet-size", settings.packet_size,
            "GigE Vision, bytes; 0: the largest that passes");
}

SourceRequest request_from(const SourceFlags& flags) {
  SourceRequest request = flags.request;
  const std::string scheme = scheme_of(request.source);
  const bool is_camera = scheme != "virtual" && scheme != "replay";
  if (!is_camera && request.camera.pixel_format == PixelFormat::rgb8) {
    throw Error(fmt::format("--pixel-format RGB8: is of a camera, and {} is none; leave it out",
                            request.source));
  }
  if (scheme == "virtual") {
    VirtualFlags world = flags.world;
    world.scanner = request.scanner;
    request.world = world_from(world);
  }
  return request;
}

}  // namespace slipstream::app
