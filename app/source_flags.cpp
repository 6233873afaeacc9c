#include "app/source_flags.h"

#include <numbers>

#include "app/commands.h"
#include "app/scan_flags.h"
#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/virtual_files.h"

namespace slipstream::app {
namespace {

/// Amplitude and period of a flag.
Swing<double> swing_from(const std::vector<double>& flag, std::string_view name, double most) {
  const Swing<double> swing{flag[0], flag[1]};
  throw_if(!(swing.amplitude >= 0 && swing.amplitude < most && swing.period > 0),
           "{} {} {} is out of range; 0 to less than {}, and frames above 0", name, flag[0],
           flag[1], most);
  return swing;
}

void add_scene_flags(CLI::App& command, VirtualFlags& flags) {
  using Numbers = std::vector<double>;
  const FlagGroup group{command, "Scene"};
  Motion& motion = flags.motion;
  group.add("--scene", flags.scene, fmt::format("{}", fmt::join(scene_names(), ", ")));
  group.add_file("--mesh", flags.mesh, "a PLY or OBJ mesh (Y up, facing +Z) instead of a scene");
  group.add("--mesh-size", flags.mesh_size, "its largest side, mm; fills the view where 0");
  group.add("--reflectivity", flags.reflectivity, "alpha of every surface, 0 to 1");
  const auto shift = [&flags](const Numbers& mm) { flags.shift = Eigen::Vector3d(mm.data()); };
  group.add_read<Numbers>("--shift", shift, "where it stands, off its own place: X Y Z, mm")
      ->expected(3);
  const auto move = [&flags](const Numbers& mm) { flags.step = Eigen::Vector3d(mm.data()); };
  group.add_read<Numbers>("--move", move, "how it moves from frame to frame: X Y Z, mm")
      ->expected(3)
      ->default_str(fmt::format("{}", fmt::join(flags.idle_step, " ")));
  const auto turn = [&motion](double degrees) {
    motion.turn.y() = degrees * std::numbers::pi / 180;
  };
  group
      .add_read<double>("--turn", turn,
                        "how it turns about its upright axis from frame to frame: degrees")
      ->default_str("0");
  const auto vibrate = [&motion](const Numbers& flag) {
    const Swing<double> swing = swing_from(flag, "--vibrate", 1000);
    motion.vibration = {{0, 0, swing.amplitude}, swing.period};
  };
  group
      .add_read<Numbers>("--vibrate", vibrate,
                         "how it swings along the view: MM each way, FRAMES a period")
      ->expected(2);
  const auto breathe = [&motion](const Numbers& flag) {
    motion.breathing = swing_from(flag, "--breathe", 1);
  };
  group
      .add_read<Numbers>("--breathe", breathe,
                         "how it grows and shrinks: SHARE each way, FRAMES a period")
      ->expected(2);
}

void add_device_flags(CLI::App& command, VirtualFlags& flags) {
  const FlagGroup group{command, "Devices"};
  group.add("--camera", flags.camera_size, "size of the example's camera")->default_str("640x480");
  group.add("--world", flags.world,
            fmt::format("{}; with changes, as bench,gloss or harsh,no-flicker: {}",
                        fmt::join(world_names(), ", "), fmt::join(effect_names(), ", ")));
  group.add("--virtual-ambient", flags.ambient, "ambient light beta, grey levels of 255");
  const auto respond = [&flags](const std::string& text) {
    flags.response = response_named(text, "--virtual-gamma");
  };
  group.add_read<>("--virtual-gamma", respond,
                   "response of projector and camera: gamma, srgb, logistic:SLOPE:CENTRE, or a "
                   "file that holds one");
  group.add("--virtual-noise", flags.noise_variance,
            "sigma_w^2, grey levels^2 of 255, in place of the world's noise");
  group.add("--camera-bits", flags.bits, "of the camera, 8 to 16")->default_str("8");
  group.add("--seed", flags.seed, "of the noise");
  group.add("--rays", flags.rays,
            "rays of each pixel at edges, 1 to 256: more put them truer and take longer");
}

}  // namespace

void add_virtual_flags(CLI::App& command, VirtualFlags& flags) {
  add_scene_flags(command, flags);
  add_device_flags(command, flags);
}

VirtualWorld world_from(VirtualFlags flags) {
  throw_if(!(!flags.scanner_file || !flags.camera_size),
           "--scanner and --camera exclude each other; the scanner file says the camera's size");
  if (flags.reflectivity) {
    const double alpha = *flags.reflectivity;
    require_in_range(alpha >= 0 && alpha <= 1, "--reflectivity", alpha, "0 to 1");
  }
  if (flags.scanner_file) {
    flags.scanner = read_scanner(*flags.scanner_file);
    require_valid(*flags.scanner);
  }
  flags.camera = flags.camera_size.value_or(flags.camera);
  if (flags.motion.is_none()) flags.motion.step = flags.idle_step;
  flags.motion.step = flags.step.value_or(flags.motion.step);
  return virtual_world(flags);
}

Sequence sequence_for(const SequenceChanges& changes, const Scanner& scanner) {
  const Size projector = scanner.projector.size;
  Sequence sequence = default_sequence(projector, changes);
  throw_if(sequence.projector != projector, "--projector {} is not that of the scanner, {}",
           text_of(sequence.projector), text_of(projector));
  return sequence;
}

void add_camera_flags(CLI::App& command, CameraSettings& settings) {
  const FlagGroup group{command, "Camera"};
  const auto expose = [&settings](double ms) { settings.exposure = ms / 1e3; };
  group.add_read<double>("--exposure", expose, "of each frame, ms");
  group.add("--gain", settings.gain, "in the camera's unit, mostly dB");
  const auto cut = [&settings](const std::string& text) {
    settings.region = rectangle_of_text(text);
    throw_if(!settings.region.has_value(),
             "--region '{}' is no region; give width x height + x + y, as 640x480+16+8", text);
  };
  group.add_read<>("--region", cut,
                   "part of the sensor, width x height + x + y, as 640x480+16+8; for v4l2 the "
                   "size");
  group.add_named("--pixel-format", settings.pixel_format, pixel_format_named,
                  name_of(settings.pixel_format),
                  "Mono8, Mono10, Mono12, Mono16, or packed: Mono10p, Mono12p, Mono10Packed, "
                  "Mono12Packed; RGB8: three patterns to a picture in colour");
  group.add("--trigger", settings.trigger,
            "the camera's input that starts each frame, as Line1; runs freely without");
  group.add("--packet-size", settings.packet_size,
            "GigE Vision, bytes; 0: the largest that passes");
}

void add_source_flags(CLI::App& command, SourceFlags& flags, bool with_marker) {
  add_camera_flags(command, flags.camera);
  add_pattern_flags(command, flags.sequence, with_marker);
  add_virtual_flags(command, flags.virtual_scanner);
}

bool is_camera(const SourceRequest& request) {
  const std::string scheme = scheme_of(request.source);
  return scheme != "virtual" && scheme != "replay";
}

SourceRequest request_from(const SourceFlags& flags) {
  SourceRequest request = flags;
  throw_if(!(is_camera(request) || request.camera.pixel_format != PixelFormat::rgb8),
           "--pixel-format RGB8: is of a camera, and {} is none; leave it out", request.source);
  if (scheme_of(request.source) == "virtual") {
    VirtualFlags world = flags.virtual_scanner;
    world.scanner_file = request.scanner;
    request.world = world_from(world);
  }
  return request;
}

NamedSource open(const SourceRequest& request, Output& output) {
  NamedSource opened = open_source(request);
  if (!opened.warning.empty()) output.warn(opened.warning);
  return opened;
}

}  // namespace slipstream::app
