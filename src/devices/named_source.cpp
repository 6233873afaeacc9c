#include "slipstream/named_source.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <ranges>
#include <string>
#include <string_view>

#include "base/throw_if-inl.h"
#include "frames/colour_channels.h"
#include "io/replay_source.h"
#include "simulate/looped_scene.h"
#include "simulate/rendered_reel.h"
#include "slipstream/recording.h"
#include "slipstream/scanner_file.h"
#include "slipstream/virtual_world.h"

namespace slipstream {
namespace {

/// Cycles of a loop: enough to see motion, or one full turn or sway if that is not too many.
int cycles_to_see(const Scene& scene, int patterns) {
  constexpr int fewest_frames = 32, fewest_cycles = 4, most_frames = 1440;
  const double turn = frames_of_a_turn(scene).value_or(frames_of_a_sway(scene));
  if (turn > fewest_frames && turn <= most_frames) {
    return std::max(1, static_cast<int>(std::lround(turn / patterns)));
  }

  return std::max(fewest_cycles, (fewest_frames - 1) / patterns + 1);
}

NamedSource open_virtual(const std::string& what, const SourceRequest& request) {
  throw_if(!what.empty(), "source virtual:{}: virtual takes no argument", what);
  if (!request.world) throw Error("source virtual: no virtual world given");

  const auto& [scanner, scene, photometry] = *request.world;

  // 1. The patterns, for the virtual projector's field.
  NamedSource opened;
  opened.sequence = default_sequence(scanner.projector.size, request.sequence);
  opened.sequence.marker |= request.marker;
  throw_if(opened.sequence.projector != scanner.projector.size,
           "`projector {}` differs from the scanner's, {}", text_of(opened.sequence.projector),
           text_of(scanner.projector.size));

  const PatternSet patterns = pattern_set(cycle_of(opened.sequence));

  // 2. Render the camera's frames, in the background.
  require_valid(photometry);
  request.before_rendering();
  auto reel = std::make_shared<RenderedReel>(
      looped_scene(scanner, scene, patterns, photometry, cycles_to_see(scene, patterns.count),
                   request.first_rest),
      request.while_rendering);

  if (request.first_rest == FirstRest::none) {  // the first frame comes when all are there
    for (std::size_t k = 0; k < reel->order().size(); ++k) {
      while (!reel->wait_for(k, RenderedReel::Clock::now() + std::chrono::hours(1))) {
      }
    }
  }

  // 3. Play it back, with the scanner as a calibration would find it.
  opened.frames = std::make_unique<VirtualCamera>(
      std::move(reel), request.rate == 0.0 ? std::nullopt : request.rate);
  opened.scanner = as_calibrated(*request.world);
  opened.scanner_name = "the virtual scanner";
  return opened;
}

NamedSource open_replay(const std::string& path, const SourceRequest& request) {
  auto replay = std::make_unique<ReplaySource>(
      path, ReplaySettings{.rate = request.rate,
                           .loop = request.loop,
                           .scan = {.sequence = request.sequence, .scanner = request.scanner}});

  const RecordingHeader& header = replay->header();
  throw_if(!header.sequence && !request.sequence.strategy,
           "{}: contains no pattern description; add `strategy`", path);

  NamedSource opened;
  opened.sequence = changed(header.sequence.value_or(Sequence{}), request.sequence);
  opened.sequence.marker |= request.marker;

  opened.warning = replay->warning();
  opened.scanner = header.scanner;
  opened.scanner_name = path;
  opened.in_colour = header.in_colour;
  if (opened.in_colour) require_in_colour(opened.sequence, path);
  opened.white = header.white;
  opened.colour = replay->colour();

  opened.frames = std::move(replay);
  return opened;
}

/// Opens a camera; it does not know the patterns.
NamedSource open_camera_source(const std::string&, const SourceRequest& request) {
  throw_if(!request.sequence.strategy,
           "{}: a camera does not know the projected patterns; add `strategy`", request.source);

  NamedSource opened;
  opened.sequence = changed({}, request.sequence);
  opened.sequence.marker |= request.marker;

  // The camera counts frames of a whole cycle: all scans, with the marker once.
  CameraSettings settings = request.camera;
  settings.frame_rate = request.rate == 0.0 ? std::nullopt : request.rate;
  settings.cycle =
      cycle_length(opened.sequence) + (request.scans - 1) * frame_count(cycle_of(opened.sequence));

  // Colour pictures carry three patterns each.
  const int patterns = values_of(settings.pixel_format);
  opened.in_colour = patterns > 1;
  if (opened.in_colour) {
    require_in_colour(opened.sequence,
                      fmt::format("`pixel_format {}`", name_of(settings.pixel_format)));
  }

  settings.cycle /= patterns;

  opened.frames = open_camera(request.source, settings);
  if (opened.in_colour) opened.frames = std::make_unique<ColourSource>(std::move(opened.frames));

  opened.scanner_name = request.source;
  return opened;
}

struct Scheme {
  std::string_view name;
  std::string_view form;
  NamedSource (*open)(const std::string& what, const SourceRequest& request);
};

constexpr std::array schemes{
    Scheme{"virtual", "virtual", open_virtual},
    Scheme{"replay", "replay:PATH", open_replay},
    Scheme{"aravis", "aravis:NAME", open_camera_source},
    Scheme{"v4l2", "v4l2:NUMBER", open_camera_source},
};

}  // namespace

std::unique_ptr<FrameSource> colours_apart(std::unique_ptr<FrameSource> channels,
                                           const NamedSource& opened) {
  if (!opened.in_colour || !opened.scanner || !opened.scanner->photometry.colour_mixture) {
    return channels;
  }
  return std::make_unique<UnmixedSource>(std::move(channels),
                                         *opened.scanner->photometry.colour_mixture, opened.white);
}

std::string source_forms() {
  return fmt::format("{}", fmt::join(schemes | std::views::transform(&Scheme::form), ", "));
}

std::string scheme_of(const std::string& source) {
  return source.substr(0, source.find(':'));
}

NamedSource open_source(const SourceRequest& request) {
  // 1. Which source it is.
  const std::string name = scheme_of(request.source);
  const std::string what = request.source.substr(std::min(name.size() + 1, request.source.size()));
  const auto* const scheme = std::ranges::find(schemes, name, &Scheme::name);
  if (scheme == schemes.end()) {
    const std::string meant =
        std::filesystem::exists(request.source)
            ? fmt::format("; did you mean replay:{}?", request.source)
            : did_you_mean(name, schemes | std::views::transform(&Scheme::name));
    throw Error(fmt::format("source '{}' is unknown; expected one of: {}{}", request.source,
                            source_forms(), meant));
  }

  const double rate = request.rate.value_or(0);
  throw_if(!(rate == 0 || (rate >= 1e-3 && rate <= 1e6)),
           "`rate {}` is out of range; expected 0 (as fast as possible) or 0.001 to 1e6 Hz", rate);

  // 2. Open it. A scanner that is given replaces the source's own.
  NamedSource opened = scheme->open(what, request);
  if (request.scanner && scheme->open != open_virtual) {  // the virtual world has its own
    opened.scanner = read_scanner(*request.scanner);
    opened.scanner_name = request.scanner->string();
  }

  // 3. Colour pictures: warn if channels cannot be unmixed, and take them apart.
  if (!opened.in_colour) return opened;
  const bool mixed = opened.scanner && opened.scanner->photometry.colour_mixture;
  const std::string doubt = doubt_about_colours(mixed, opened.white.count() != 0);
  opened.warning += opened.warning.empty() || doubt.empty() ? doubt : "; " + doubt;

  if (request.as_taken) return opened;
  opened.frames = colours_apart(std::move(opened.frames), opened);
  opened.in_colour = false;
  return opened;
}

}  // namespace slipstream
