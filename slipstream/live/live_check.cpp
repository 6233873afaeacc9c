#include "slipstream/live/live_check.h"

#include <algorithm>
#include <cstddef>

namespace slipstream {
namespace {

/// So few cost next to nothing beside a cycle's clouds.
constexpr ScanSamples::Effort few{
    .most_looked = 384, .fewest_looked = 48, .lit_wanted = 32, .all_places = false};

/// While something stays amiss it is looked into whole so often: it may have become something else.
constexpr std::chrono::milliseconds next_look{500};

}  // namespace

LiveCheck::LiveCheck(const Sequence& sequence, const std::optional<Scanner>& scanner, Size camera,
                     const CheckSettings& settings)
    : sequence_(sequence),
      scanner_(scanner),
      settings_(settings),
      model_(sequence, scanner ? scanner->photometry : settings.photometry),
      order_(model_.identity()),
      judge_(model_),
      samples_(camera, frame_count(sequence.strategy)) {}

bool LiveCheck::darkened() const {
  constexpr double much = 0.5;
  for (std::size_t n = 0; n < right_sums_.size(); ++n) {
    if (samples_.sums()[n] < much * right_sums_[n]) return true;
  }
  return false;
}

LiveCheck::Suspicion LiveCheck::suspicion(const FrameViews& window) {
  ScanSamples::Effort effort = few;
  effort.least_range = least_range(settings_);
  samples_.take(window, effort);
  // A frame 5 percent brighter leaves 0.012 and more of its variation.
  constexpr double most_residual = 0.011;
  fit_.moving = settings_.moving;
  fit_.frames = judge_(samples_, order_);
  Suspicion raised;
  raised[0] = fit_.frames.residual > std::max(most_residual, harmless_residual_);
  raised[1] = !fit_.bands_agree();
  raised[2] = !fit_.no_seam();
  raised[3] = darkened();
  return raised;
}

std::vector<Finding> LiveCheck::look(const FrameViews& window) {
  const bool first = checked_ == Clock::time_point{};
  const Suspicion raised = suspicion(window);
  if (!raised.any()) right_sums_.assign(samples_.sums().begin(), samples_.sums().end());
  const Clock::time_point now = Clock::now();
  if (!findings_.empty()) {
    if (suspected_.any() && !raised.any()) {
      findings_.clear();  // what was seen has gone
      return {};
    }
    if (raised == suspected_ && now - checked_ < next_look) return findings_;
  } else {
    harmless_ &= raised;
    if (!first && harmless_ == raised) return {};
  }
  findings_ = check_frames(window, sequence_, scanner_, settings_).findings;
  checked_ = now;
  suspected_ = raised;
  // What the whole check finds nothing in, as motion, need not be looked into again.
  if (findings_.empty()) {
    harmless_ = raised;
    harmless_residual_ = 1.3 * fit_.frames.residual;
  }
  return findings_;
}

}  // namespace slipstream
