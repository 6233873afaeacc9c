#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/bundle_adjustment.h"

namespace slipstream {

/// Numbers of distortion coefficients, in OpenCV's order, that make a lens model: none, k1, and k2,
/// and tangential, and k3, rational, and thin prism.
inline constexpr std::array<int, 7> lens_models{0, 1, 2, 4, 5, 8, 12};

/// "none", "k1", "k1 k2", ... as reported.
const char* name_of_lens_model(int coefficients);

/// The coefficients of a lens model by a text: one of `lens_models`, or none for "auto". Throws
/// Error, by `name` what a message calls the text, for another.
std::optional<int> lens_model_named(const std::string& text, const std::string& name);

/// How well a lens model foresees poses that it was not calibrated with.
struct LensModelScore {
  int coefficients = 0;
  double error = 0;  ///< RMS of the left-out poses' corners, in standard deviations
};

struct LensChoice {
  int coefficients = 0;
  std::vector<LensModelScore> scores;  ///< of the models that were tried; empty where by flag
};

/// Which device of a BundleState.
enum class Device { camera, projector };

/// The simplest lens model that the data support: each is calibrated without some of the
/// poses, a quarter or, of six and fewer, one, for each in turn, and then has to explain how
/// both devices see those with nothing free but the board's place. Chosen is the one with the
/// fewest coefficients that is not worse than the best by more than the standard error of the
/// difference; k1 k2 without the tangential ones is not tried. `state` is what the calibrations
/// start from; the board's corners stay where it says.
LensChoice choose_lens_model(const std::vector<BoardView>& views, const BundleState& state,
                             Device device);

}  // namespace slipstream
