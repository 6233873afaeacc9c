#include "slipstream/frames/slip_watch.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace slipstream {
namespace {

/// A pattern shows where a cycle goes at least so far up and down, grey levels of 255.
constexpr float least_range = 16;
/// Fewer samples than these tell nothing.
constexpr int fewest_samples = 16;
/// How much nearer another index must be before it is believed. Noise leaves two distances about
/// equal; two patterns of which only one is right are further apart than that.
constexpr float nearer = 0.5F;

constexpr std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

SlipWatch::SlipWatch(int cycle, std::size_t samples)
    : count_(cycle),
      last_(at(cycle), std::vector<float>(samples)),
      known_(at(cycle)),
      distances_(at(cycle)),
      suspects_(at(cycle), Seen{0, std::vector<float>(samples)}) {}

int SlipWatch::moved(int index, int places) const {
  return (index + places % count_ + count_) % count_;
}

bool SlipWatch::has_cycle() const {
  return std::find(known_.begin(), known_.end(), false) == known_.end();
}

void SlipWatch::measure_distances(const std::vector<float>& samples) {
  std::fill(distances_.begin(), distances_.end(), 0.0F);
  int used = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    float least = samples[i], greatest = samples[i];
    for (const auto& frame : last_) {
      least = std::min(least, frame[i]);
      greatest = std::max(greatest, frame[i]);
    }
    if (greatest - least < least_range) continue;
    ++used;
    for (std::size_t index = 0; index < last_.size(); ++index) {
      distances_[index] += std::abs(samples[i] - last_[index][i]);
    }
  }
  if (used < fewest_samples || !has_cycle()) {
    std::fill(distances_.begin(), distances_.end(), std::numeric_limits<float>::infinity());
  }
}

void SlipWatch::keep(int index, const std::vector<float>& samples) {
  std::copy(samples.begin(), samples.end(), last_[at(index)].begin());
  known_[at(index)] = true;
}

void SlipWatch::suspect(int index, const std::vector<float>& samples) {
  Seen& seen = suspects_[at(suspected_++)];
  seen.index = index;
  std::copy(samples.begin(), samples.end(), seen.samples.begin());
}

void SlipWatch::settle(int places) {
  for (int i = 0; i < suspected_; ++i) {
    keep(moved(suspects_[at(i)].index, places), suspects_[at(i)].samples);
  }
  suspected_ = 0;
}

SlipWatch::Finding SlipWatch::look(int index, const std::vector<float>& samples) {
  measure_distances(samples);
  const float own = distances_[at(index)];
  const auto nearest = std::min_element(distances_.begin(), distances_.end());
  const auto much_nearer = [](float a, float b) { return std::isfinite(b) && a <= nearer * b; };

  const bool other = much_nearer(*nearest, own);
  const int places = moved(static_cast<int>(nearest - distances_.begin()), -index);
  if (other && (suspected_ == 0 || places != places_)) {
    settle(0);
    suspected_ = supporting_ = 0;
    places_ = places;
  }
  if (suspected_ == 0 && !other) {
    keep(index, samples);
    return {};
  }
  if (much_nearer(own, distances_[at(moved(index, places_))])) {
    settle(0);
    keep(index, samples);
    return {};
  }
  suspect(index, samples);
  if (other) ++supporting_;
  if (suspected_ == count_) {
    const bool slipped = 2 * supporting_ >= count_;
    settle(slipped ? places_ : 0);
    if (slipped) return {Verdict::slipped, places_};
    return {};
  }
  return {other ? Verdict::slipping : Verdict::agrees, 0};
}

void SlipWatch::move_on(int places) {
  const int first = moved(0, -places);
  std::rotate(last_.begin(), last_.begin() + first, last_.end());
  std::rotate(known_.begin(), known_.begin() + first, known_.end());
  suspected_ = 0;
}

}  // namespace slipstream
