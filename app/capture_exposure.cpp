#include "app/capture_exposure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "app/monitor_projector.h"
#include "app/process.h"
#include "response/automatic_exposure.h"

namespace slipstream::app {
namespace {

/// The flags for scans with these exposures: in ms, for the virtual camera relative.
CaptureFlags with_exposures(CaptureFlags flags, const std::vector<double>& exposures) {
  flags.automatic.reset();

  const bool is_virtual = scheme_of(flags.source.source) == "virtual";
  if (!is_virtual && exposures.size() == 1) {
    flags.source.camera.exposure = exposures.front() / 1e3;
  } else {
    flags.source.sequence.exposures = exposures;
  }
  return flags;
}

double mean_level(const Frame& frame) {
  constexpr std::size_t step = 7;  // enough of the pixels
  return std::visit(
      [](const auto& image) {
        double sum = 0;
        std::size_t count = 0;
        for (std::size_t i = 0; i < image.pixel_count(); i += step, ++count) {
          sum += image.begin()[i];
        }
        return sum / static_cast<double>(std::max<std::size_t>(count, 1));
      },
      frame.pixels);
}

/// The period, ms, of the room's light, from frames of a short exposure; 0 if it is steady or the
/// camera cannot tell.
double measured_flicker(FrameSource& source) {
  constexpr double short_exposure = 2;  // ms
  constexpr std::size_t wanted = 48;
  constexpr double patience = 3;  // s

  CameraControls* const controls = source.controls();
  const auto before = controls ? controls->control(CameraControl::exposure) : std::nullopt;
  if (!before) return 0;
  controls->set_control(CameraControl::exposure,
                        std::clamp(short_exposure, before->least, before->most));

  std::vector<double> times, levels;
  Frame frame(source.format());
  for (const RunEnd end(patience); levels.size() < wanted && !end.reached();) {
    if (source.next(frame, std::chrono::milliseconds(200)) != Arrival::frame) continue;
    const FrameStamp& stamp = frame.stamp;
    const std::chrono::duration<double> time =
        stamp.device_time.count() != 0 ? std::chrono::duration<double>(stamp.device_time)
                                       : stamp.host_time.time_since_epoch();
    times.push_back(time.count());
    levels.push_back(mean_level(frame));
  }

  controls->set_control(CameraControl::exposure, before->value);
  return 1e3 * flicker_period(times, levels).value_or(0);
}

/// A multiple of the projector's refreshes, ms, that holds whole periods of the room's light.
double common_period(double refresh, double flicker) {
  constexpr int most_refreshes = 12;
  constexpr double nearly = 0.02;  // of a period
  if (refresh == 0 || flicker == 0) return std::max(refresh, flicker);

  for (int n = 1; n <= most_refreshes; ++n) {
    const double periods = n * refresh / flicker;
    if (std::abs(periods - std::round(periods)) <= nearly) return n * refresh;
  }
  return refresh;
}

/// The exposures of the camera for which there is time.
ExposureLimits limits_of(const CaptureFlags& flags, Output& output) {
  const bool is_virtual = scheme_of(flags.source.source) == "virtual";
  if (is_virtual) return {.shortest = 1.0 / 64, .longest = 64};

  CaptureFlags look = flags;
  look.automatic.reset();
  const CaptureRig rig = open_rig(look, output);
  CameraControls* const controls = rig.opened.frames->controls();
  const auto exposure = controls ? controls->control(CameraControl::exposure) : std::nullopt;
  throw_if(!exposure, "--auto: {} has no exposure that can be set; use --exposures",
           flags.source.source);

  // Only a projector that this program drives waits for several exposures, or shows steady light.
  ExposureLimits limits{
      .first = exposure->value, .shortest = exposure->least, .longest = exposure->most, .most = 1};
  if (flags.monitor) {
    limits.most = 3;
    const double flicker =
        flags.source.camera.trigger.empty() ? measured_flicker(*rig.opened.frames) : 0;
    if (flicker > 0) output.say("the room's light flickers: {:.4g} ms", flicker);
    const double refresh = rig.projector.refresh_hz > 0 ? 1e3 / rig.projector.refresh_hz : 0;
    limits.flicker_period = common_period(refresh, flicker);
    limits.refresh_period = refresh;
    output.document["flicker_ms"] = flicker;
  }

  // Half of the time is for the scan itself.
  const double patterns = frame_count(rig.opened.sequence.strategy);
  limits.total = std::max(limits.shortest, 1e3 * *flags.automatic / 2 / patterns - flags.settle);
  limits.longest = std::min(limits.longest, limits.total);
  limits.first = std::clamp(limits.first, limits.shortest, limits.longest);
  rig.opened.frames->stop();
  return limits;
}

}  // namespace

void require_automatic_possible(const CaptureFlags& flags) {
  require_in_range(*flags.automatic >= 1 && *flags.automatic <= 3600, "--auto", *flags.automatic,
                   "1 to 3600 s");
  throw_if(flags.poses.has_value(), "--auto: board poses use one --exposure; drop --auto");
  throw_if(flags.source.sequence.exposures.has_value(),
           "--auto chooses the exposures; drop --exposures");
  throw_if(scheme_of(flags.source.source) == "replay",
           "--auto: {} was taken with its exposures; drop --auto", flags.source.source);
}

CaptureFlags with_chosen_exposures(const CaptureFlags& flags, Output& output) {
  const RunEnd half(*flags.automatic / 2);
  const ExposureLimits limits = limits_of(flags, output);

  // 1. Scans with one exposure after another.
  Sequence sequence;
  const auto take = [&](double exposure) {
    CaptureFlags once = with_exposures(flags, {exposure});
    once.no_guard = true;
    const CaptureRig rig = open_rig(once, output);
    FrameSet frames = std::move(still_frames(rig, output).front());
    rig.opened.frames->stop();
    sequence = rig.opened.sequence;

    // One axis without motion frames is enough.
    const int patterns = frame_count(sequence.strategy), others = frames.count() - patterns;
    if (others > 0) return std::move(parts_of(std::move(frames), {patterns, others}).front());
    return frames;
  };

  // The sequence is known with the first scan, which is not taken again.
  std::optional<FrameSet> first = take(limits.first);
  const Sequence known = sequence;
  const auto take_next = [&](double exposure) {
    return first ? *std::exchange(first, std::nullopt) : take(exposure);
  };
  const ChosenExposures chosen =
      choose_exposures(take_next, known, limits, {}, [&] { return !half.reached(); });

  // 2. The choice, and how to keep it.
  const bool is_virtual = scheme_of(flags.source.source) == "virtual";
  const char* const unit = is_virtual ? "" : " ms";
  output.say("exposures {:.3g}{}: {:.1f} % of the lit pixels, by scans with {:.3g}",
             fmt::join(chosen.exposures, ","), unit, 100 * chosen.measured,
             fmt::join(chosen.tried, ", "));
  const bool is_one = !is_virtual && chosen.exposures.size() == 1;
  output.say("the same in a rig file: {}",
             is_one ? fmt::format("exposure: {:.4g}", chosen.exposures.front())
                    : fmt::format("exposures: [{:.4g}]", fmt::join(chosen.exposures, ", ")));
  output.document["automatic"] = described("exposures", chosen.exposures, "tried", chosen.tried,
                                           "lit", chosen.lit, "measured", chosen.measured);
  return with_exposures(flags, chosen.exposures);
}

}  // namespace slipstream::app
