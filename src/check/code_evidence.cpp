#include "check/code_evidence.h"

// Evidence in the frames of a code that needs no geometry.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <numeric>
#include <optional>
#include <ranges>
#include <span>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

using Complex = std::complex<double>;
using Place = ScanSamples::Place;

constexpr double most_offset = 0.035;  // of the origin, periods

/// A pixel's bits, the finest last: of the Gray code or of the plain code, without its base.
struct Word {
  unsigned stripe = 0, bits = 0;
  unsigned doubtful = 0;  ///< bits too near to the threshold
  unsigned halfway = 0;   ///< bits in the middle half between the pixel's dark and bright ones
};

/// `I`: intensities in pattern order.
Word word_of(const Code& code, const std::vector<double>& I) {
  constexpr double noise_levels = 3, noise_share = 0.05;
  const auto [dark, bright] =
      std::ranges::minmax(code.frames | std::views::transform([&](int n) { return I[n]; }));

  // Bits this near to the threshold, in grey levels, may be noise or blur.
  const auto [shown, doubtful] =
      code_bits(code, I, std::max(noise_levels, noise_share * (bright - dark)));

  // A blurred base bit spoils the whole word, so that no single bit can be left out.
  const double middle_half = std::max(noise_levels, (bright - dark) / 4);
  const unsigned halfway = code.base ? 0 : code_bits(code, I, middle_half).doubtful;

  // In a Gray code neighbouring stripes differ in one bit of the word.
  const auto stripe = static_cast<unsigned>(stripe_of(code, shown));
  return {stripe, code.gray ? stripe ^ (stripe >> 1U) : stripe, doubtful, halfway};
}

/// Steps from stripe to stripe between neighbours at one distance.
struct Steps {
  std::vector<std::pair<Word, Word>> pairs{};
  /// A count for each bit, the finest first.
  using Counts = std::array<int, most_code_bits>;

  /// How many of the bits are too fine for this distance or blurred, whichever frames they are in.
  [[nodiscard]] int too_fine(bool gray) const {
    Counts changes{}, doubts{}, halfways{}, ones{};
    for (const auto& [a, b] : pairs) {
      for (std::size_t i = 0; i < changes.size(); ++i) {
        changes[i] += static_cast<int>(((a.bits ^ b.bits) >> i) & 1U);
        doubts[i] += static_cast<int>((a.doubtful >> i) & 1U);
        halfways[i] += static_cast<int>((a.halfway >> i) & 1U);
        ones[i] += static_cast<int>((a.bits >> i) & 1U);
      }
    }

    // Share of the neighbours that an edge parts if stripes are two distances wide; in a Gray code
    // every other edge is one of the finest bit. Random bits change between half of them.
    const double most = gray ? 0.25 : 0.375;
    const auto count_of = static_cast<double>(pairs.size());

    int count = 0;
    for (std::size_t i = 0; i < changes.size(); ++i) {
      // Too many changes: narrower than the distance. Mostly doubtful: blurred. A tone curve moves
      // blurred stripes to one side of the threshold.
      const bool is_narrow = changes[i] > most * count_of;
      const bool is_on_one_side = 3 * std::max<double>(ones[i], count_of - ones[i]) > 2 * count_of;
      const bool is_moved = 2 * halfways[i] > count_of && is_on_one_side;
      if (is_narrow || 2 * doubts[i] > count_of || is_moved) ++count;
    }

    return count;
  }

  /// Counts steps, by the coarsest bit that changes, and those by more than `most` stripes.
  void count(bool gray, unsigned most, Counts& all, Counts& wrong) const {
    // Leave out the bits that are too fine to tell stripes apart here.
    const int finer = too_fine(gray);
    for (const auto& [a, b] : pairs) {
      // The change in Gray code: one bit where the stripes are next to each other.
      const unsigned from = a.stripe >> finer, to = b.stripe >> finer;
      const unsigned changed = (from ^ (from >> 1U)) ^ (to ^ (to >> 1U));

      // The finest bit may change anywhere.
      if (changed < 2 || ((a.doubtful | b.doubtful) >> finer) != 0 ||
          (gray && !std::has_single_bit(changed)))
        continue;

      const auto coarsest = std::bit_width(changed) - 1 + finer;
      ++all[coarsest];
      if (std::max(from, to) - std::min(from, to) > most) ++wrong[coarsest];
    }
  }
};

constexpr double usual = 0.3;  ///< share of wrong steps at depth edges, at most

/// The largest share of wrong steps that exceeds the usual one by 5 standard deviations: a few
/// edges of a coarse bit may all lie at depth edges.
double excess_share(const Steps::Counts& all, const Steps::Counts& wrong) {
  constexpr double deviations = 5;

  double most = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double excess = wrong[i] - usual * all[i];
    // Against the standard deviation of a binomial count with the usual share.
    if (excess > deviations * std::sqrt(usual * (1 - usual) * all[i])) {
      most = std::max(most, static_cast<double>(wrong[i]) / all[i]);
    }
  }

  return most;
}

/// Wrong steps of a plain code between pixels next to each other, which see finer bits than far
/// ones: as excess_share().
double torn_plain(const Steps& next) {
  Steps::Counts all{}, wrong{}, again{}, not_next{};
  next.count(false, 2, all, wrong);
  next.count(false, 1, again, not_next);

  const auto finest = static_cast<std::size_t>(
      std::ranges::find_if(all, [](int count) { return count > 0; }) - all.begin());
  int coarser = 0, moved = 0;
  for (std::size_t bit = finest + 1; bit < all.size(); ++bit) {
    coarser += all[bit];
    moved += not_next[bit];
  }

  // A finest bit in another place moves all steps by one more stripe, two finest bits that are
  // exchanged only those within both.
  if (finest < all.size() && moved <= usual * coarser) wrong[finest] = not_next[finest];

  return excess_share(all, wrong);
}

double torn(const std::array<Steps, ScanSamples::places>& distances, bool gray) {
  // In a plain code a wrong finest bit moves a step by one more stripe.
  Steps::Counts all{}, wrong{};
  for (const Steps& steps : distances) steps.count(gray, gray ? 1 : 2, all, wrong);
  const double of_all = excess_share(all, wrong);
  if (gray) return of_all;

  // Along the axis, where stripes part most of them.
  const auto parted = [&](Place place) {
    return std::ranges::count_if(distances[place].pairs, [](const auto& pair) {
      return pair.first.stripe != pair.second.stripe;
    });
  };
  const bool is_along_y = parted(Place::below) > parted(Place::right);
  return std::max(of_all, torn_plain(distances[is_along_y ? Place::below : Place::right]));
}

/// Phases half way between neighbours in stripes next to each other.
struct Edges {
  int count = 0, against = 0;
  double changes = 0;  ///< sum
  Complex along{}, backwards{};
  std::array<Complex, 2> halves{};  ///< of `along`, in either half of the field
  std::array<Complex, 2> halves_backwards{};

  /// Phases and the edge between them, periods; `second`: in the second half of the field.
  void add(double here, double next, double edge, bool rising, bool second) {
    constexpr double most_change = 0.3;  // beyond, the direction is uncertain
    const double change = next - here - std::round(next - here);
    if (std::abs(change) > most_change) return;

    // The phase rises with the stripes, unless the steps shift the other way.
    ++count;
    changes += std::abs(change);
    if (rising != (change > 0)) ++against;

    // The phase half way between both pixels against the expected one at the edge, for either
    // direction of the shifts.
    const Complex at_edge = std::polar(1.0, two_pi * (here + change / 2 - edge));
    along += at_edge;
    halves[second ? 1 : 0] += at_edge;

    const Complex reversed = std::polar(1.0, -two_pi * (here + change / 2 + edge));
    backwards += reversed;
    halves_backwards[second ? 1 : 0] += reversed;
  }

  void sum_up(CodeEvidence& evidence) const {
    constexpr int fewest = 16;
    constexpr double moved_by_blur = 0.1;  // pixels
    if (count < fewest) return;

    evidence.has_edges = true;
    evidence.against = static_cast<double>(against) / count;

    // The mean of n random directions has a length of about 1 / sqrt(n).
    const bool is_against = evidence.against > 0.5;
    const Complex mean = (is_against ? backwards : along) / Complex(count);
    const double chance = 1 / std::sqrt(count);
    evidence.incoherence = std::max(0.0, 1 - std::abs(mean) - chance);

    // The middles of the halves are half a field apart.
    const auto& [first, second] = is_against ? halves_backwards : halves;
    evidence.drift = 2 * std::arg(second * std::conj(first)) / two_pi;

    // Blur moves the edges by a tenth of a pixel: that much is not an error of the origin.
    const double offset = std::arg(mean) / two_pi;
    const bool is_off = std::abs(offset) > most_offset + moved_by_blur * changes / count;
    evidence.offset = is_off ? offset : std::clamp(offset, -most_offset, most_offset);
  }
};

constexpr std::array<SymptomCause, 2> of_bits{
    {{CauseKind::frame_order, "code frames in another order"},
     {CauseKind::pattern_settings, "another code than configured"}}};

}  // namespace

// Limits: right scans, real ones among them, reach 0.17 of doubt and 0.28 of blur, and stay below
// half of the other limits; wrong orders and periods give 0.35 to 0.5 of doubt.
const std::array<CodeSymptom, 9> code_symptoms{{
    {FindingKind::beyond_black_or_white,
     "white and black do not part the code's dark bits from its bright ones in over {:g} % of the "
     "lit pixels",
     "share of the lit pixels",
     &CodeEvidence::disordered,
     0.1,
     {{{CauseKind::frame_order, "white or black frame missing or in another place"},
       {CauseKind::flicker, "automatic exposure or gain"}}},
     "compare the frames with"},
    {FindingKind::unlisted_code_words,
     "code words without a stripe in over {:g} % of the lit pixels",
     "share of the lit pixels",
     &CodeEvidence::unlisted,
     0.05,
     {{{CauseKind::pattern_settings,
        "another code or another number of periods or stripes than configured"}}},
     "compare the settings with"},
    {FindingKind::contradicting_bits,
     "a bit of the code and its inverse together are too bright, and elsewhere too dark, each in "
     "over {:g} % of the lit pixels",
     "share of the lit pixels", &CodeEvidence::unpaired, 0.05, of_bits, "compare the frames with"},
    {FindingKind::contradicting_bits,
     "a bit of the code is blurred in over {:g} % more of the lit pixels than a finer bit",
     "share of the lit pixels", &CodeEvidence::blurred, 0.5, of_bits, "compare the frames with"},
    {FindingKind::contradicting_bits,
     "the code's bits contradict each other at over {:g} % of a bit's edges", "share of the edges",
     &CodeEvidence::torn, 0.3, of_bits, "compare the frames with"},
    {FindingKind::code_against_phase,
     "phase and code contradict each other: incoherence at the code's edges above {:g} %",
     "incoherence",
     &CodeEvidence::incoherence,
     0.3,
     {{{CauseKind::frame_order, "code frames in another order"},
       {CauseKind::pattern_settings, "another number of periods than configured"}}},
     "compare the settings with"},
    {FindingKind::phase_origin_off,
     "the phase origin is off by over {:g} % of a period",
     "periods",
     &CodeEvidence::offset,
     most_offset,
     {{{CauseKind::pattern_settings, "another phase origin or number of periods than configured"}}},
     "compare the settings with"},
    {FindingKind::phase_direction_reversed,
     "the phase runs against the code at over {:g} % of its edges",
     "share of the edges",
     &CodeEvidence::against,
     0.5,
     {{{CauseKind::pattern_settings, "another direction of the phase shifts than configured"}}},
     "compare `backwards` with"},
    {FindingKind::no_coordinate_fits,
     "no coordinate fits all frames: the median misfit is over {:g} % of the next best",
     "median doubt",
     &CodeEvidence::doubt,
     0.3,
     {{{CauseKind::pattern_settings, "another number of periods than configured"},
       {CauseKind::frame_order, "frames in another order"}}},
     "compare the settings with"},
}};

namespace {

/// Reads the code words of the sampled pixels, and compares neighbours.
class CodeJudge {
 public:
  CodeJudge(const FrameModel& model, const ScanSamples& samples, const FrameOrder& order,
            bool phases)
      : model_(model),
        samples_(samples),
        order_(order),
        code_(*model.layout().code),
        band_(model.measuring_band()),
        periods_(model.layout().bands[band_].periods),
        phases_(phases),
        levels_(order.size()) {
    // White and black come after the bits.
    const auto& reference = code_.reference;
    const std::size_t after = std::ranges::max(code_.frames) + 1;
    const bool has_white = code_.inverses.empty() && after + 1 < reference.size() &&
                           reference[after] == 0.5 && reference[after + 1] == 0.5;
    if (has_white) white_ = after;
  }

  CodeEvidence operator()() {
    for (std::size_t g = 0; g < samples_.groups(); ++g) {
      // 1. The pixel by itself.
      const Word here = read(samples_.levels(g, Place::middle));
      if (here.stripe >= std::ceil(code_.stripes) && here.doubtful == 0) ++unlisted_;
      if (is_disordered()) ++disordered_;
      count_unpaired();
      for (std::size_t bit = 0; bit < unsure_.size(); ++bit) {
        unsure_[bit] += here.doubtful >> bit & 1U;
        halfway_[bit] += here.halfway >> bit & 1U;
        ones_[bit] += here.bits >> bit & 1U;
      }

      // 2. Against its neighbours.
      for (const Place place : {Place::right, Place::below, Place::far_right, Place::far_below}) {
        if (samples_.lit(g, place)) compare(g, here, place);
      }
    }

    return summed_up();
  }

 private:
  /// The code word of a pixel; leaves its levels in `levels_`.
  Word read(const float* levels) {
    std::ranges::transform(order_, levels_.begin(), [&](int frame) { return levels[frame]; });
    return word_of(code_, levels_);
  }

  /// Periods.
  double phase(const float* levels) {
    model_.read(levels, order_, reading_);
    return reading_.phase[band_] / two_pi;
  }

  /// Whether the middle of white and black does not part the dark bits of the pixel read last from
  /// the bright ones. A bit may well be brighter than white: sharpening overshoots at edges, and an
  /// automatic exposure differs from frame to frame.
  [[nodiscard]] bool is_disordered() const {
    if (!white_) return false;

    const auto [dark, bright] = std::ranges::minmax(
        code_.frames | std::views::transform([&](int n) { return levels_[n]; }));
    const double white = levels_[*white_], black = levels_[*white_ + 1];

    // Bits that are all dark, or all bright, show nothing.
    constexpr double noise_levels = 12, least_share = 0.2;
    if (bright - dark < std::max(noise_levels, std::abs(white - black) / 2)) return false;

    const double place = ((white + black) / 2 - dark) / (bright - dark);
    return place < least_share || place > 1 - least_share;
  }

  /// Counts the bits of the pixel read last that, with their inverses, are brighter or darker than
  /// a dark and a bright frame.
  void count_unpaired() {
    if (code_.inverses.empty()) return;
    const auto range_of = [&](const std::vector<int>& frames) {
      return std::ranges::minmax(frames | std::views::transform([&](int n) { return levels_[n]; }));
    };
    const auto bits = range_of(code_.frames), inverses = range_of(code_.inverses);
    const double dark = std::min(bits.min, inverses.min), bright = std::max(bits.max, inverses.max);

    // Frames of different bits are both bright in some pixels and both dark in others; if one of
    // them is blurred away, their sum is still off by half of the range.
    constexpr double least_share = 0.4;
    for (std::size_t bit = 0; bit < code_.frames.size(); ++bit) {
      const double sum = levels_[code_.frames[bit]] + levels_[code_.inverses[bit]];
      const double excess = sum - dark - bright, least = least_share * (bright - dark);
      if (excess > least) ++too_bright_[bit];
      if (-excess > least) ++too_dark_[bit];
    }
  }

  /// Adds the step from stripe to stripe, and the phase where they are next to each other.
  void compare(std::size_t g, const Word& here, Place place) {
    const float* const there = samples_.levels(g, place);
    const Word next = read(there);
    steps_[place].pairs.emplace_back(here, next);

    const bool far = place == Place::far_right || place == Place::far_below;
    if (!phases_ || far) return;

    // An edge is clear if no bit is doubtful but the one that changes there.
    const bool rising = next.stripe > here.stripe;
    const unsigned edge = std::max(here.stripe, next.stripe);
    const bool clear = ((here.doubtful | next.doubtful) & ~(here.bits ^ next.bits)) == 0;
    if (!clear || edge - std::min(here.stripe, next.stripe) != 1) return;

    const double before = phase(samples_.levels(g, Place::middle));
    edges_.add(before, phase(there), periods_ * model_.edge_of_stripe(static_cast<int>(edge)),
               rising, 2 * edge > code_.stripes);
  }

  /// See CodeEvidence.
  [[nodiscard]] double blurred(double pixels) const {
    // A tone curve may move stripes that are all blurred to one side of the threshold.
    constexpr double least_share = 0.25;

    double most = 0, least_halfway = 1;
    for (std::size_t bit = 0; bit < code_.frames.size(); ++bit) {
      const double ones = ones_[bit] / pixels, halfway = halfway_[bit] / pixels;
      most = std::max(most, halfway - least_halfway);
      if (std::min(ones, 1 - ones) > least_share) least_halfway = std::min(least_halfway, halfway);
    }
    return most;
  }

  [[nodiscard]] CodeEvidence summed_up() const {
    const auto n = static_cast<double>(samples_.groups());
    CodeEvidence evidence;
    evidence.disordered = disordered_ / n;
    evidence.unlisted = unlisted_ / n;
    for (std::size_t bit = 0; bit < too_dark_.size(); ++bit) {
      const double both = std::min(too_bright_[bit], too_dark_[bit]) / n;
      evidence.unpaired = std::max(evidence.unpaired, both);
    }
    evidence.torn = torn(steps_, code_.gray);
    evidence.blurred = blurred(n);

    // Stripes narrower than the distance to the next pixel leave no edge to compare with.
    const bool fine = steps_[Place::right].too_fine(code_.gray) > 0 ||
                      steps_[Place::below].too_fine(code_.gray) > 0;
    const bool alone = model_.layout().unwrapping->whole_stripes;
    if (!alone && !fine) edges_.sum_up(evidence);

    if (alone && !code_.inverses.empty()) {
      // The stripes part neighbours along the patterns' axis alone.
      const int finer = std::max(steps_[Place::right].too_fine(code_.gray),
                                 steps_[Place::below].too_fine(code_.gray));
      const auto resolved = unsure_ | std::views::drop(finer);
      evidence.unsure = resolved.empty() ? 1 : std::ranges::max(resolved) / n;
    }

    return evidence;
  }

  const FrameModel& model_;
  const ScanSamples& samples_;
  const FrameOrder& order_;
  const Code& code_;
  std::size_t band_;
  double periods_;                      ///< of the measuring band
  bool phases_;                         ///< whether to compare phases with the code
  std::optional<std::size_t> white_{};  ///< its frame, next to the black one; if there are both

  SampleReading reading_;
  std::vector<double> levels_;  ///< of one pixel, in the order of the patterns
  std::array<Steps, ScanSamples::places> steps_;
  Edges edges_;
  int disordered_ = 0, unlisted_ = 0;
  std::array<int, most_code_bits> too_bright_{}, too_dark_{};  ///< pixels: a bit and its inverse
  /// Pixels, of each bit, the finest first.
  std::array<unsigned, most_code_bits> unsure_{}, halfway_{}, ones_{};
};

}  // namespace

CodeEvidence code_evidence(const FrameModel& model, const ScanSamples& samples,
                           const FrameOrder& order, bool phases) {
  if (!model.layout().code || samples.groups() == 0) return {};
  return CodeJudge(model, samples, order, phases)();
}

}  // namespace slipstream
