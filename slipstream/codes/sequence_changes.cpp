#include "slipstream/codes/sequence_changes.h"

#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/registry.h"

namespace slipstream {

namespace {

/// What is said in projector pixels, in parts of the field.
void add_settings_in_pixels(const SequenceChanges& changes, int length,
                            StrategySettings& settings) {
  if (!changes.period_pixels && !changes.stripe_pixels) return;
  if (length == 0) throw Error("lengths in projector pixels need its size: --projector 1920x1080");
  const auto across_field = [length](double pixels) {
    if (!(pixels > 0)) throw Error(fmt::format("{} projector pixels are no length", pixels));
    return length / pixels;
  };
  if (changes.stripe_pixels) settings["stripes"] = across_field(*changes.stripe_pixels);
  if (!changes.period_pixels) return;
  std::vector<double> periods;
  for (const double pixels : *changes.period_pixels) periods.push_back(across_field(pixels));
  settings["periods"] = periods;
}

}  // namespace

SequenceChanges changes_to(const Sequence& sequence) {
  return {.strategy = sequence.strategy.name(), .known = sequence};
}

Sequence changed(const Sequence& first, const SequenceChanges& changes) {
  const Sequence& known = changes.known ? *changes.known : first;
  const bool replaced = changes.strategy && *changes.strategy != known.strategy.name();
  StrategySettings settings = replaced ? StrategySettings{} : known.strategy.settings();
  for (const auto& [name, value] : changes.settings) {
    if (value) settings[name] = *value;
  }
  Sequence sequence = known;
  if (changes.axes) set_axes(sequence, *changes.axes);
  if (sequence.projector == Size{}) sequence.projector = first.projector;
  sequence.projector = changes.projector.value_or(sequence.projector);
  add_settings_in_pixels(changes, length_along(sequence.axis, sequence.projector), settings);
  sequence.strategy = make_strategy(changes.strategy.value_or(known.strategy.name()), settings);
  // Frames that were taken apart stay so.
  const bool read = known.strategy.is_spectral() && !known.strategy.demodulation();
  if (read && !replaced) sequence.strategy = sequence.strategy.read_as();
  sequence.light.alpha_p = changes.alpha_p.value_or(known.light.alpha_p);
  sequence.light.beta_p = changes.beta_p.value_or(known.light.beta_p);
  require_valid(sequence.light);
  sequence.exposures = changes.exposures.value_or(known.exposures);
  sequence.marker = known.marker || changes.marker;
  sequence.binary = known.binary || changes.binary;
  sequence.motion = changes.motion.value_or(known.motion);
  require_mergeable(sequence);
  return sequence;
}

Sequence default_sequence(Size projector, const SequenceChanges& changes) {
  const Sequence sequence =
      changed({.strategy = default_strategy(), .projector = projector}, changes);
  require_shown(sequence);
  return sequence;
}

}  // namespace slipstream
