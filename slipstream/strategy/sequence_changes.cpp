#include "slipstream/strategy/sequence_changes.h"

#include "slipstream/strategy/registry.h"

namespace slipstream {

Sequence changed(const Sequence& known, const SequenceChanges& changes) {
  const bool replaced = changes.strategy && *changes.strategy != known.strategy.name();
  StrategySettings settings = replaced ? StrategySettings{} : known.strategy.settings();
  for (const auto& [name, value] : changes.settings) {
    if (value) settings[name] = *value;
  }
  Sequence sequence = known;
  sequence.strategy = make_strategy(changes.strategy.value_or(known.strategy.name()), settings);
  sequence.axis = changes.axis.value_or(known.axis);
  sequence.light.alpha_p = changes.alpha_p.value_or(known.light.alpha_p);
  sequence.light.beta_p = changes.beta_p.value_or(known.light.beta_p);
  require_valid(sequence.light);
  sequence.projector = changes.projector.value_or(known.projector);
  sequence.exposures = changes.exposures.value_or(known.exposures);
  require_mergeable(sequence);
  sequence.marker = known.marker || changes.marker;
  sequence.binary = known.binary || changes.binary;
  return sequence;
}

Sequence default_sequence(Size projector, const SequenceChanges& changes) {
  const Sequence sequence =
      changed({.strategy = default_strategy(), .projector = projector}, changes);
  require_shown(sequence);
  return sequence;
}

}  // namespace slipstream
