#include "app/source_flags.h"

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/numbers.h"
#include "slipstream/named_scenes.h"
#include "slipstream/recording.h"
#include "slipstream/virtual_world.h"

namespace slipstream::app {
namespace {

/// Amplitude and period from a flag.
Swing<double> swing_from(const std::vector<double>& flag, std::string_view name, double most) {
  const Swing<double> swing{flag[0], flag[1]};
  throw_if(
      !(swing.amplitude >= 0 && swing.amplitude < most && swing.period > 0),
      "{} {} {} is out of range; expected an amplitude from 0 to below {}, and more than 0 frames",
      name, flag[0], flag[1], most);
  return swing;
}

void add_scene_flags(CLI::App& command, VirtualFlags& flags) {
  using Numbers = std::vector<double>;
  const FlagGroup group{command, "Scene"};

  Motion& motion = flags.motion;

  // The object.
  group.add("--scene", flags.scene, fmt::format("{}", fmt::join(scene_names(), ", ")));
  group.add_file("--mesh", flags.mesh, "PLY or OBJ mesh (Y up, facing +Z) instead of a scene");
  group.add("--mesh-size", flags.mesh_size, "largest side of the mesh, mm; 0: fills the view");

  // Its place and motion.
  const auto shift = [&flags](const Numbers& mm) { flags.shift = Eigen::Vector3d(mm.data()); };
  group.add_read<Numbers>("--shift", shift, "shift of the object: X Y Z, mm")->expected(3);
  const auto move = [&flags](const Numbers& mm) { flags.step = Eigen::Vector3d(mm.data()); };
  group.add_read<Numbers>("--move", move, "motion per frame: X Y Z, mm")
      ->expected(3)
      ->default_str(fmt::format("{}", fmt::join(flags.idle_step, " ")));

  const auto turn = [&motion](double degrees) { motion.turn.y() = degrees * degree; };
  group.add_read<double>("--turn", turn, "rotation per frame about the vertical axis, degrees")
      ->default_str("0");

  const auto vibrate = [&motion](const Numbers& flag) {
    const Swing<double> swing = swing_from(flag, "--vibrate", 1000);
    motion.vibration = {{0, 0, swing.amplitude}, swing.period};
  };
  group
      .add_read<Numbers>("--vibrate", vibrate,
                         "oscillation along the view: amplitude in mm, period in frames")
      ->expected(2);

  const auto breathe = [&motion](const Numbers& flag) {
    motion.breathing = swing_from(flag, "--breathe", 1);
  };
  group
      .add_read<Numbers>("--breathe", breathe,
                         "oscillating size: relative amplitude, period in frames")
      ->expected(2);
}

void add_device_flags(CLI::App& command, VirtualFlags& flags) {
  const FlagGroup group{command, "Devices"};
  group.add("--camera", flags.camera_size, "picture size of the example camera")
      ->default_str("640x480");

  group.add("--world", flags.world,
            fmt::format("{}; with changes, e.g. bench,gloss or harsh,no-flicker: {}",
                        fmt::join(world_names(), ", "), fmt::join(effect_names(), ", ")));

  const auto respond = [&flags](const std::string& text) {
    flags.response = response_named(text, "--virtual-gamma");
  };

  group.add_read<>(
      "--virtual-gamma", respond,
      "response of projector and camera: a gamma, srgb, logistic:SLOPE:CENTRE, or a file with one");

  group.add_settings(flags);
  command.get_option("--camera-bits")->default_str("8");
  command.get_option("--reflectivity")->group("Scene");
}

/// Exposure, gain, the part of the sensor and the pixel format.
void add_picture_flags(const FlagGroup& group, CameraSettings& settings) {
  const auto expose = [&settings](double ms) { settings.exposure = ms / 1e3; };
  group.add_read<double>("--exposure", expose, "exposure time per frame, ms");

  group.add("--gain", settings.gain, "camera gain, in the camera's unit, usually dB");
  group.add("--region", settings.region,
            "part of the sensor, width x height + x + y, e.g. 640x480+16+8; v4l2: only the size");

  const auto read = [&settings](const std::string& text) { set_pixel_format(settings, text); };
  group
      .add_read<>("--pixel-format", read,
                  "Mono8, Mono10, Mono12, Mono16, or packed: Mono10p, Mono12p, Mono10Packed, "
                  "Mono12Packed; BayerRG8 and so on: a colour sensor's mosaic, read as grey; RGB8: "
                  "three patterns per colour picture; MJPG: webcams, lossy")
      ->default_str("Mono8");
}

/// What starts a frame, and what advances the projector.
void add_wiring_flags(const FlagGroup& group, CameraSettings& settings) {
  group.add("--trigger", settings.trigger,
            "camera input that starts each frame, e.g. Line1; default: free-running");

  group.add("--strobe", settings.strobe,
            "camera output that advances the projector at each exposure, e.g. Line1");

  const auto delay = [&settings](double ms) { settings.strobe_delay = ms / 1e3; };
  group.add_read<double>("--strobe-delay", delay, "from the start of the exposure to a pulse, ms")
      ->needs("--strobe");

  group
      .add("--strobe-inverted", settings.strobe_inverted,
           "low during the exposure, for projectors that advance at a falling edge")
      ->needs("--strobe");
}

/// The nodes are set in the order given.
void add_node_flag(const FlagGroup& group, CameraSettings& settings) {
  const auto set = [&settings](const std::vector<std::string>& nodes) {
    for (const std::string& node : nodes) {
      const std::size_t equals = node.find('=');
      throw_if(equals == 0 || equals == std::string::npos,
               "--feature '{}': expected NAME=VALUE, e.g. LineSource=ExposureActive", node);
      settings.nodes.push_back({node.substr(0, equals), node.substr(equals + 1)});
    }
  };

  group
      .add_read<std::vector<std::string>>(
          "--feature", set, "set any GenICam node: NAME=VALUE, may be repeated, in this order")
      ->expected(1)
      ->take_all();
}

}  // namespace

void add_virtual_flags(CLI::App& command, VirtualFlags& flags) {
  add_scene_flags(command, flags);
  add_device_flags(command, flags);
}

VirtualWorld world_from(VirtualFlags flags) {
  throw_if(flags.scanner_file && flags.camera_size,
           "--scanner and --camera exclude each other; the scanner file sets the camera's size");

  if (flags.scanner_file) {
    flags.scanner = read_scanner(*flags.scanner_file);
    require_valid(*flags.scanner);
  }

  flags.camera = flags.camera_size.value_or(flags.camera);

  // --move goes before the idle motion, which applies if no flag sets the scene in motion.
  if (flags.motion.is_none()) flags.motion.step = flags.idle_step;
  flags.motion.step = flags.step.value_or(flags.motion.step);

  return virtual_world(flags);
}

Sequence sequence_for(const SequenceChanges& changes, const Scanner& scanner) {
  const Size projector = scanner.projector.size;
  Sequence sequence = default_sequence(projector, changes);

  throw_if(sequence.projector != projector, "--projector {} differs from the scanner's, {}",
           text_of(sequence.projector), text_of(projector));
  return sequence;
}

void add_camera_flags(CLI::App& command, CameraSettings& settings) {
  const FlagGroup group{command, "Camera"};
  add_picture_flags(group, settings);
  add_wiring_flags(group, settings);
  add_node_flag(group, settings);

  group.add("--packet-size", settings.packet_size,
            "GigE Vision packet size, bytes; 0: the largest the network passes");
}

void add_source_flags(CLI::App& command, SourceFlags& flags, bool with_marker) {
  add_camera_flags(command, flags.camera);
  add_pattern_flags(command, flags.sequence, with_marker);
  add_virtual_flags(command, flags.virtual_scanner);
}

void add_limit_flag(CLI::App& command, FileLimit& limit) {
  const auto read = [&limit](const std::string& text) { limit = file_limit_from(text); };
  FlagGroup{command}.add_read<>(
      "--limit", read,
      "size or time of a recording or MCAP file at which it stops, e.g. 20GB or 10min; "
      "20GB,ring keeps the newest");
}

bool is_camera(const SourceRequest& request) {
  const std::string scheme = scheme_of(request.source);
  return scheme != "virtual" && scheme != "replay";
}

void require_sees_monitor(const SourceRequest& request, int monitor) {
  throw_if(!is_camera(request), "--monitor {}: {} cannot see a monitor; drop --monitor", monitor,
           request.source);
  throw_if(request.camera.pixel_format == PixelFormat::rgb8,
           "--pixel-format RGB8: --monitor shows grey patterns; use Mono8, or show colour patterns "
           "with `slipstream project --colour`");
}

std::vector<Image<std::uint8_t>> pictures_to_show(Sequence sequence) {
  sequence.marker = false;
  require_shown(sequence);
  return patterns_in_8_bits(pattern_set(sequence), sequence.projector);
}

SourceRequest request_from(const SourceFlags& flags) {
  SourceRequest request = flags;
  throw_if(!is_camera(request) && request.camera.pixel_format == PixelFormat::rgb8,
           "--pixel-format RGB8: applies to cameras, and {} is not one; drop it", request.source);

  // The virtual scanner has the scanner file's geometry, if one is named.
  if (scheme_of(request.source) == "virtual") {
    VirtualFlags world = flags.virtual_scanner;
    world.scanner_file = request.scanner;
    request.world = world_from(world);
  }

  return request;
}

NamedSource open(SourceRequest request, Output& output) {
  request.camera.node_set = [&output](const CameraNode& node) {
    output.say("{} = {}", node.name, node.value);
  };

  if (!request.while_rendering) {
    request.while_rendering = progress_of("rendering the virtual camera's frames");
  }
  NamedSource opened = open_source(request);

  if (request.camera.pixel_format == PixelFormat::mjpg) {
    output.warn("--pixel-format MJPG: lossy compression adds errors of depth; expose brightly");
  }

  if (!opened.warning.empty()) output.warn(opened.warning);
  return opened;
}

std::function<void()> news_of(const FrameSource& source, Output& output) {
  return [&source, &output, shown = std::string()]() mutable {
    const std::string state = source.state();
    if (state != std::exchange(shown, state)) {
      output.warn(state.empty() ? "the camera is back" : state);
    }
  };
}

}  // namespace slipstream::app
