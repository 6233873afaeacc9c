#include "slipstream/strategy/decoder.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream {
Decoder::Decoder(Strategy strategy, int length, Backend backend, PhaseCorrections corrections,
                 const CueSettings& cue)
    : strategy_(strategy),
      length_(length),
      cue_(cue),
      phase_(backend, step_counts(strategy), std::move(corrections)) {
  std::visit([](const auto& chosen) { chosen.require_valid(); }, strategy_);
  require_resolved(strategy_, length);
  require_valid(cue_);
}

DecodedScan Decoder::operator()(const FrameSet& frames, double least_modulation) const {
  if (frames.count() != frame_count(strategy_)) {
    throw Error(fmt::format("{} frames given; {} takes {}", frames.count(), name_of(strategy_),
                            frame_count(strategy_)));
  }
  CueSettings cue = cue_;
  const double grey_level = frames.full_scale() / 255;
  cue.least_modulation = std::max(cue.least_modulation, least_modulation / grey_level);
  return std::visit([&](const auto& chosen) { return chosen.decode(frames, phase_, length_, cue); },
                    strategy_);
}

std::string Decoder::backend_for(const FrameSet& frames) const {
  std::string names;
  for (const int steps : step_counts(strategy_)) {
    const std::string name(name_of(phase_.backend_for(steps, frames)));
    if (names.empty()) {
      names = name;
    } else if (names != name) {
      names += ", " + name;
    }
  }
  return names.empty() ? std::string(name_of(Backend::equation)) : names;
}

}  // namespace slipstream
