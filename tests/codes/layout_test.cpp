#include "slipstream/layout.h"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/unwrapping.h"

namespace slipstream::layout_test {

using std::numbers::pi;

/// Bands of three steps each, one after another.
Layout hierarchy(const std::vector<double>& periods) {
  const int frames = 3 * static_cast<int>(periods.size());
  Layout layout{.frames = frames, .unwrapping = Unwrapping::hierarchical};
  for (const double f : periods) {
    const int first = 3 * static_cast<int>(layout.bands.size());
    layout.bands.push_back(phase_shifted_band(frames, first, 3, f));
  }
  return layout;
}

Layout one_band(double periods, int steps = 3) {
  return {.frames = steps, .bands = {phase_shifted_band(steps, 0, steps, periods)}};
}

/// A band of many periods with a cue: by default that of 3 steps, in the DC channel.
Layout with_cue(std::vector<double> weights = mean_weights(3), double periods = 4) {
  const int steps = static_cast<int>(weights.size());
  return {.frames = steps,
          .bands = {phase_shifted_band(steps, 0, steps, periods, 1, 0.5)},
          .cue = Cue{.share = 0.5, .weights = std::move(weights)},
          .unwrapping = Unwrapping::vote};
}

/// A band of three steps and two frames of one sinusoid each.
Layout with_single_frames() {
  return {.frames = 5,
          .bands = {phase_shifted_band(5, 0, 3, 12)},
          .single_frames = {{.frame = 3, .periods = 13}, {.frame = 4, .periods = 11.5}},
          .unwrapping = Unwrapping::single_frames};
}

/// A cue that is a second band in the second full phase channel of five steps.
Layout with_second_band() {
  return {
      .frames = 5,
      .bands = {phase_shifted_band(5, 0, 5, 12, 1, 0.6), phase_shifted_band(5, 0, 5, 1, 2, 0.4)},
      .unwrapping = Unwrapping::vote};
}

TEST(Layout, BandsAreEquations15And16And385And386) {
  for (const int N : {3, 4, 5, 6, 9}) {
    for (const int channel : {1, 2}) {
      const Band band = phase_shifted_band(N + 5, 2, N, 7, channel, 0.6);
      EXPECT_EQ(band.periods, 7);
      EXPECT_EQ(band.share, 0.6);
      ASSERT_EQ(band.cosine.size(), static_cast<std::size_t>(N + 5));
      for (int frame = 0; frame < N + 5; ++frame) {
        const auto i = static_cast<std::size_t>(frame);
        const int n = frame - 2;
        const bool shown = n >= 0 && n < N;
        const double angle = 2 * pi * channel * n / N;
        EXPECT_NEAR(band.cosine[i], shown ? 2.0 / N * std::cos(angle) : 0, 1e-15);
        EXPECT_NEAR(band.sine[i], shown ? 2.0 / N * std::sin(angle) : 0, 1e-15);
        EXPECT_NEAR(band.mean[i], shown ? 1.0 / N : 0, 1e-15);
      }
    }
    const Band first = phase_shifted_band(N, 0, N, 1);
    EXPECT_EQ(first.mean, mean_weights(N));
  }
  EXPECT_EQ(half_phase_weights(), (std::vector{0.25, -0.25, 0.25, -0.25}));  // (3.70)
}

/// Of the sinusoid A + B cos(phi - 2 pi n / N) in its frames, whatever the others show, the sums
/// are B cos(phi), B sin(phi) and A; of the other channel they are nothing.
TEST(Layout, ABandHasItsOwnChannelAndNoOther) {
  for (const int N : {5, 6, 8}) {
    for (const int channel : {1, 2}) {
      const Band band = phase_shifted_band(N + 2, 1, N, 3, channel);
      const Band other = phase_shifted_band(N + 2, 1, N, 3, 3 - channel);
      double C = 0, S = 0, A = 0, C_other = 0, S_other = 0;
      for (int n = -1; n <= N; ++n) {
        const auto i = static_cast<std::size_t>(n + 1);
        const double I =
            n < 0 || n == N ? 200 : 120 + 80 * std::cos(1.3 - 2 * pi * channel * n / N);
        C += band.cosine[i] * I;
        S += band.sine[i] * I;
        A += band.mean[i] * I;
        C_other += other.cosine[i] * I;
        S_other += other.sine[i] * I;
      }
      EXPECT_NEAR(C, 80 * std::cos(1.3), 1e-12);
      EXPECT_NEAR(S, 80 * std::sin(1.3), 1e-12);
      EXPECT_NEAR(A, 120, 1e-12);
      EXPECT_NEAR(std::hypot(C_other, S_other), 0, 1e-12);
    }
  }
}

TEST(Layout, ARunOfStepsIsRecognised) {
  for (const int N : {3, 4, 5, 6, 16}) {
    for (const int first : {0, 1, 7}) {
      for (const int after : {0, 2}) {
        const Band band = phase_shifted_band(first + N + after, first, N, 5, 1, 0.4);
        EXPECT_EQ(step_run(band), (StepRun{first, N}));
        EXPECT_TRUE(is_channel(band, {first, N}, 1));
        EXPECT_FALSE(is_channel(band, {first, N}, 2));
      }
    }
  }
  EXPECT_EQ(step_counts(hierarchy({1, 6})), (std::vector{3, 3}));
  EXPECT_EQ(step_counts(with_second_band()), (std::vector{5}));
}

TEST(Layout, ARunBeginsAnywhereAndRunsEitherWay) {
  for (const double origin : {0.0, 0.5, -2.5, 3.0}) {
    for (const bool backwards : {false, true}) {
      const Shifts shifts{origin, backwards};
      for (const int N : {3, 4, 7}) {
        const Band band = phase_shifted_band(N + 2, 1, N, 6, 1, 1, shifts);
        const std::optional<StepRun> run = step_run(band);
        ASSERT_TRUE(run);
        EXPECT_EQ(run->first, 1);
        EXPECT_EQ(run->steps, N);
        EXPECT_NEAR(run->shifts.origin, origin, 1e-12);
        EXPECT_EQ(run->shifts.backwards, backwards);
        double C = 0, S = 0;
        const double y = 0.123, phi = 2 * pi * 6 * y;
        for (int n = 0; n < N; ++n) {
          const double I = sinusoid_intensity({N, 6, shifts}, n, y);
          C += band.cosine[static_cast<std::size_t>(n + 1)] * I;
          S += band.sine[static_cast<std::size_t>(n + 1)] * I;
        }
        EXPECT_NEAR(C, 0.5 * std::cos(phi), 1e-12);
        EXPECT_NEAR(S, 0.5 * std::sin(phi), 1e-12);
        EXPECT_NEAR(
            std::remainder(unshifted_phase(shifts, shifted_phase(shifts, phi)) - phi, 2 * pi), 0,
            1e-12);
      }
    }
  }
}

TEST(Layout, BeatsAreUnwrappedByTheSurestChain) {
  Layout layout = hierarchy({1, 64, 70, 75});
  layout.bands.erase(layout.bands.begin());
  layout.unwrapping = Unwrapping::beats;
  require_valid(layout, "beats");
  const std::vector<PhaseSum> chain = unwrapping_chain(layout);
  ASSERT_GE(chain.size(), 3U);
  EXPECT_LE(chain.front().periods, 1);
  EXPECT_EQ(chain.back().periods, 75);
  for (const PhaseSum& sum : chain) {
    double periods = 0;
    for (std::size_t i = 0; i < 3; ++i) periods += sum.of[i] * layout.bands[i].periods;
    EXPECT_NEAR(sum.periods, periods, 1e-12);
  }
  const std::vector<double> weights = band_weights(layout);
  EXPECT_NEAR(weights[0] + weights[1] + weights[2], 1, 1e-12);
  EXPECT_NEAR(weights[0] / weights[2], 64.0 * 64 / (75.0 * 75), 1e-12);
  // All bands at once are at least as sure as any chain of them.
  const double by_beats = unwrapping_margin(layout);
  layout.unwrapping = Unwrapping::likelihood;
  EXPECT_GE(unwrapping_margin(layout), by_beats);
}

TEST(Layout, CodeNumbersItsStripes) {
  for (const int base : {-1, 5, 4}) {
    for (const bool gray : {false, true}) {
      Code code{.stripes = 50, .frames = {0, 1, 2, 3, 4, 5}, .gray = gray};
      if (base >= 0) code.base = base;
      require_valid(code, 6, "code");
      for (int stripe = 0; stripe < 50; ++stripe) {
        std::vector<double> I;
        for (int bit = 0; bit < 6; ++bit) {
          I.push_back(is_bright(code, bit, (stripe + 0.5) / 50) ? 200 : 55);
        }
        const CodeReading reading = read_code(code, I);
        const bool all_alike = std::equal(I.begin() + 1, I.end(), I.begin());
        if (!all_alike) EXPECT_EQ(reading.first, stripe);
        EXPECT_EQ(reading.last, reading.first);
        EXPECT_EQ(reading.spread, 0);
        EXPECT_NEAR(reading.contrast, all_alike ? 0 : 72.5, 1e-9);
      }
    }
  }
}

/// The bits, then white and black, with the last `blurred` bits half way between.
std::vector<double> frames_of(const Code& code, int stripe, int blurred, double above) {
  std::vector<double> I;
  const int bits = static_cast<int>(code.frames.size());
  for (int bit = 0; bit < bits; ++bit) {
    const bool bright = is_bright(code, bit, (stripe + 0.5) / code.stripes);
    I.push_back(bit >= bits - blurred ? 100 + above : bright ? 140 : 60);
  }
  I.insert(I.end(), {140, 60});
  return I;
}

TEST(Layout, CodeIsMeasuredByItsReferenceWithBitsThatAreDoubtfulAlone) {
  Code code{.stripes = 64, .frames = {0, 1, 2, 3, 4, 5}};
  code.reference = {0, 0, 0, 0, 0, 0, 0.5, 0.5};
  for (int stripe = 0; stripe < 64; ++stripe) {
    for (const double above : {-1.0, 1.0, 4.0}) {
      for (const int blurred : {0, 1, 2}) {
        const CodeReading reading = read_code(code, frames_of(code, stripe, blurred, above), 1);
        EXPECT_EQ(reading.contrast, 40);
        if (blurred == 0) EXPECT_EQ(reading.first, stripe);
        if (above > 3) {
          EXPECT_EQ(reading.spread, 0);
        } else {
          // All stripes that the other bits leave.
          EXPECT_EQ(reading.spread, (1 << blurred) - 1);
          EXPECT_LE(reading.first, stripe);
          EXPECT_GE(reading.last, stripe);
        }
      }
    }
    EXPECT_EQ(read_code(code, frames_of(code, stripe, 5, 1), 1).spread, code.stripes);
  }
}

TEST(Layout, OtherWeightsAreNoRunOfSteps) {
  const Band run = phase_shifted_band(6, 1, 4, 5);
  const auto changed = [&](const std::function<void(Band&)>& change) {
    Band band = run;
    change(band);
    return band;
  };
  for (const Band& band :
       {phase_shifted_band(5, 0, 5, 1, 2),                              // the second channel
        changed([](Band& b) { std::swap(b.cosine[1], b.cosine[2]); }),  // another order
        changed([](Band& b) { b.cosine[1] += 1e-6; }),                  //
        changed([](Band& b) { b.sine[5] = 1e-6; }),                     // outside the run
        changed([](Band& b) { b.mean[2] += 1e-6; }),                    //
        changed([](Band& b) { b.mean = {0.5, 0, 0, 0, 0, 0.5}; }),      // with a gap
        changed([](Band& b) { b.mean = std::vector<double>(6); }),      // none at all
        Band{.cosine = {1, 0, -1}, .sine = {0, 1, -1}, .mean = {0, 0, 1}},
        Band{.cosine = {1, -1}, .sine = {1, -1}, .mean = {0.5, 0.5}}}) {  // too short
    EXPECT_FALSE(step_run(band));
  }
  const Layout own{.frames = 3,
                   .bands = {{.cosine = {1, 0, -1}, .sine = {0, 1, -1}, .mean = {0, 0, 1}}}};
  EXPECT_TRUE(step_counts(own).empty());
}

TEST(Layout, ThoseOfTheStrategiesAreValid) {
  for (const Layout& layout :
       {one_band(1), one_band(16), one_band(0.8, 7), hierarchy({1}), hierarchy({1, 16}),
        hierarchy({0.5, 4, 24}), hierarchy({36, 1, 6}), with_cue(), with_cue(half_phase_weights()),
        with_second_band(), with_single_frames()}) {
    EXPECT_NO_THROW(require_valid(layout, "layout"));
  }
}

TEST(Layout, RefusesWhatIsNone) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  struct Case {
    std::string why;
    Layout layout;
    std::function<void(Layout&)> change;
  };
  const std::vector<Case> cases{
      {"no frames", one_band(1), [](Layout& l) { l.frames = 0; }},
      {"no bands", one_band(1), [](Layout& l) { l.bands.clear(); }},
      {"no period", one_band(1), [](Layout& l) { l.bands[0].periods = 0; }},
      {"periods below 0", one_band(1), [](Layout& l) { l.bands[0].periods = -1; }},
      {"periods not a number", one_band(1), [&](Layout& l) { l.bands[0].periods = nan; }},
      {"infinite periods", one_band(1), [&](Layout& l) { l.bands[0].periods = infinity; }},
      {"no share", one_band(1), [](Layout& l) { l.bands[0].share = 0; }},
      {"a share above 1", one_band(1), [](Layout& l) { l.bands[0].share = 1.01; }},
      {"a share that is no number", one_band(1), [&](Layout& l) { l.bands[0].share = nan; }},
      {"a cosine too few", one_band(1), [](Layout& l) { l.bands[0].cosine.pop_back(); }},
      {"a sine too many", one_band(1), [](Layout& l) { l.bands[0].sine.push_back(0); }},
      {"no weights of the mean", one_band(1), [](Layout& l) { l.bands[0].mean.clear(); }},
      {"a frame more than weights", one_band(1), [](Layout& l) { ++l.frames; }},
      {"a frame that is no single one", with_single_frames(),
       [](Layout& l) { l.single_frames.pop_back(); }},
      {"a single frame twice", with_single_frames(),
       [](Layout& l) { l.single_frames.push_back(l.single_frames.front()); }},
      {"a weight that is no number", one_band(1), [&](Layout& l) { l.bands[0].sine[1] = nan; }},
      {"infinite weights", one_band(1), [&](Layout& l) { l.bands[0].mean[0] = infinity; }},
      {"a cosine of constant light", one_band(1), [](Layout& l) { l.bands[0].cosine[0] += 0.1; }},
      {"a sine of constant light", one_band(1), [](Layout& l) { l.bands[0].sine[0] += 0.1; }},
      {"a mean that is none", one_band(1), [](Layout& l) { l.bands[0].mean[0] += 0.1; }},
      {"a second band's cosine", hierarchy({1, 4}), [](Layout& l) { l.bands[1].cosine[0] += 1; }},
      {"a carrier of one sinusoid alone", one_band(1), [](Layout& l) { l.bands[0].carrier = 9; }},
      {"a mirrored sinusoid without a carrier", one_band(1),
       [](Layout& l) { l.bands[0].mirrored = l.bands; }},
      {"a carrier that is no number", one_band(1),
       [&](Layout& l) {
         l.bands[0].mirrored = l.bands;
         l.bands[0].carrier = nan;
       }},
      {"no band to begin with", hierarchy({2, 16}), [](Layout&) {}},
      {"no beat of one period", hierarchy({1, 20, 30, 40}),
       [](Layout& l) {
         l.bands.erase(l.bands.begin());
         l.unwrapping = Unwrapping::beats;
       }},
      {"phases that repeat in the field", hierarchy({12, 16}),
       [](Layout& l) { l.unwrapping = Unwrapping::likelihood; }},
      {"no code", hierarchy({12}), [](Layout& l) { l.unwrapping = Unwrapping::code; }},
      {"a code of too few stripes", hierarchy({12}),
       [](Layout& l) {
         l.unwrapping = Unwrapping::code;
         l.code = Code{.stripes = 8, .frames = {0, 1, 2}, .reference = {0, 0, 0}};
       }},
      {"a code of too few bits", hierarchy({12}),
       [](Layout& l) {
         l.unwrapping = Unwrapping::code;
         l.code = Code{.stripes = 12, .frames = {0, 1, 2}, .reference = {0, 0, 0}};
       }},
      {"voting requires", with_cue(), [](Layout& l) { l.cue.reset(); }},
      {"a cue too short", with_cue(), [](Layout& l) { l.cue->weights.pop_back(); }},
      {"a cue of half the light", with_cue(),
       [](Layout& l) {
         l.cue->weights = {0.5, 0, 0};
       }},
      {"a cue that is no number", with_cue(), [&](Layout& l) { l.cue->weights[0] = nan; }},
      {"a cue without share", with_cue(), [](Layout& l) { l.cue->share = 0; }},
      {"a cue that leaves nothing", with_cue(), [](Layout& l) { l.cue->share = 1; }},
      {"a cue and two bands", with_cue(), [](Layout& l) { l.bands.push_back(l.bands[0]); }},
      {"periods not whole under a cue", with_cue(mean_weights(3), 4.5), [](Layout&) {}},
      {"a cue band of two periods", with_second_band(), [](Layout& l) { l.bands[1].periods = 2; }},
      {"two cue bands", with_second_band(), [](Layout& l) { l.bands.push_back(l.bands.back()); }}};
  for (const Case& bad : cases) {
    Layout layout = bad.layout;
    bad.change(layout);
    try {
      require_valid(layout, "own-coding");
      ADD_FAILURE() << bad.why;
    } catch (const Error& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("own-coding: "))
          << bad.why << ": " << error.what();
    }
  }
}

TEST(Layout, BandsAreOrderedByTheirPeriodsWhereverTheyStand) {
  using Order = std::vector<std::size_t>;
  EXPECT_EQ(coarse_to_fine(hierarchy({1, 6, 36})), (Order{0, 1, 2}));
  EXPECT_EQ(coarse_to_fine(hierarchy({6, 36, 1})), (Order{2, 0, 1}));
  EXPECT_EQ(measuring_band_index(hierarchy({6, 36, 1})), 1U);
  EXPECT_EQ(measuring_band(hierarchy({36, 1, 6})).periods, 36);
  EXPECT_EQ(highest_frequency(hierarchy({36, 1, 6})), 36);
  EXPECT_EQ(least_periods(hierarchy({36, 0.5, 6})), 0.5);
  EXPECT_EQ(measuring_band_index(hierarchy({1, 1})), 0U) << "of two alike the first measures";
  EXPECT_EQ(least_periods(with_cue()), 1);
  EXPECT_EQ(least_periods(with_second_band()), 1);
  EXPECT_EQ(least_periods(one_band(0.8)), 0.8);
}

TEST(Layout, KnowsWhatItsFramesGive) {
  struct Case {
    Layout layout;
    bool coordinate, ambient_light;
  };
  for (const auto& [layout, coordinate, ambient_light] :
       {Case{one_band(1), true, false}, Case{one_band(0.5), true, false},
        Case{one_band(1.5), false, false}, Case{hierarchy({1, 16}), true, false},
        Case{with_cue(), true, true}, Case{with_cue(half_phase_weights()), true, false},
        Case{with_second_band(), true, false}}) {
    EXPECT_EQ(has_coordinate(layout), coordinate);
    EXPECT_EQ(needs_ambient_light(layout), ambient_light);
  }
}

TEST(Layout, IsEqualWhereNothingDiffers) {
  EXPECT_EQ(hierarchy({1, 6}), hierarchy({1, 6}));
  EXPECT_EQ(with_cue(), with_cue());
  const auto square = [](double y) { return 1 - 2 * y * y; };
  const auto with_reference = [](const CueReference& reference) {
    Layout layout = with_cue();
    layout.cue->reference = reference;
    return layout;
  };
  EXPECT_EQ(with_reference(CueReference(square)), with_reference(CueReference(square)));

  EXPECT_NE(hierarchy({1, 6}), hierarchy({6, 1}));
  EXPECT_NE(one_band(1), one_band(1, 4));
  EXPECT_NE(one_band(1), hierarchy({1})) << "another rule";
  EXPECT_NE(with_cue(), with_cue(mean_weights(3), 5));
  Layout other = with_cue();
  other.bands[0].share = 0.6;
  EXPECT_NE(with_cue(), other);
  other = with_cue();
  other.cue->share = 0.4;
  EXPECT_NE(with_cue(), other);
  other.cue.reset();
  EXPECT_NE(with_cue(), other);
  EXPECT_NE(with_cue(), with_reference(CueReference(CueReference::Form::cosine)));
  EXPECT_NE(with_cue(), with_reference(CueReference(square)));
  EXPECT_NE(with_reference(CueReference(square)),
            with_reference(CueReference([](double y) { return 1 - 2 * y; })));
}

TEST(Layout, CueReferenceFollowsTheFieldThereAndBack) {
  for (const CueReference& reference : {CueReference(), CueReference(CueReference::Form::cosine),
                                        CueReference([](double y) { return 1 - 2 * y * y; }),
                                        CueReference([](double y) { return y * y * y; })}) {
    for (double y = 0; y <= 1; y += 0.01) {
      EXPECT_NEAR(reference(reference.inverse(reference(y))), reference(y), 1e-12);
      if (y > 0.05) EXPECT_NEAR(reference.inverse(reference(y)), y, 1e-9);
    }
    EXPECT_EQ(reference(-0.3), reference(0));
    EXPECT_EQ(reference(1.3), reference(1));
  }
  EXPECT_DOUBLE_EQ(CueReference()(0.3), -0.4);                                          // (3.53)
  EXPECT_DOUBLE_EQ(CueReference(CueReference::Form::cosine)(0.3), std::cos(0.3 * pi));  // (3.68)
  EXPECT_THROW(CueReference([](double y) { return std::cos(2 * pi * y); }), Error);
  EXPECT_THROW(CueReference([](double y) { return 2 * y; }), Error) << "leaves -1 to 1";
  EXPECT_THROW(CueReference([](double) { return 0.5; }), Error);
}

}  // namespace slipstream::layout_test
