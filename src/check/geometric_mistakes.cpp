#include "check/geometric_mistakes.h"

#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "geometry/lens_residual.h"

namespace slipstream {
namespace {

/// A mistake that leaves frames and settings as they are.
PossibleMistake& add_geometric(std::vector<PossibleMistake>& list, CauseKind kind,
                               std::string likely, Remedy remedy) {
  PossibleMistake mistake;
  mistake.cause = {kind, std::move(likely)};
  mistake.remedies = {std::move(remedy)};
  mistake.geometric = true;
  return list.emplace_back(std::move(mistake));
}

/// Scanner files, each with its mistake mended.
void add_scanner_files(const Scanner& scanner, std::vector<PossibleMistake>& list) {
  const auto file = [&](std::string_view what, const char* advice, const auto& mend,
                        CauseKind kind = CauseKind::scanner_file) {
    Scanner mended = scanner;
    mend(mended);
    add_geometric(list, kind, fmt::format("a scanner file {}", what), {advice}).scanner = mended;
  };

  const auto invert = [](Scanner& inverted) {
    inverted.rotation.transposeInPlace();
    inverted.translation = (-inverted.rotation * inverted.translation).eval();
  };

  const auto swap = [](Scanner& swapped) {
    std::swap(swapped.camera.intrinsic, swapped.projector.intrinsic);
    std::swap(swapped.camera.distortion, swapped.projector.distortion);
    std::swap(swapped.camera.residual, swapped.projector.residual);
  };

  file("whose rotation and translation go from the projector to the camera",
       "invert them: they must go from the camera's frame to the projector's", invert);

  file("whose rotation is inverted",
       "transpose it: it must go from the camera's frame to the projector's",
       [](Scanner& transposed) { transposed.rotation.transposeInPlace(); });

  file("whose translation has the wrong sign",
       "negate it: it is the camera's position in the projector's frame",
       [](Scanner& negated) { negated.translation *= -1; });

  file("with camera and projector swapped", "swap their matrices", swap);
  file("with camera and projector swapped",
       "swap their matrices, and invert rotation and translation", [&](Scanner& both) {
         swap(both);
         invert(both);
       });

  for (const double scale : {0.5, 2.0}) {
    const char* const large = scale < 1 ? "twice as large" : "half as large";
    const auto larger = [scale](Lens& lens) {
      lens.intrinsic.topRows<2>() *= scale;
      lens.residual = scaled(std::move(lens.residual), scale);
    };

    file(
        fmt::format("for camera pictures {}", large), "use pictures of the calibrated size",
        [&](Scanner& scaled) { larger(scaled.camera); }, CauseKind::picture_size);
    file(
        fmt::format("for projector pictures {}", large), "set `projector` to the calibrated size",
        [&](Scanner& scaled) { larger(scaled.projector); }, CauseKind::projector_size);
  }
}

}  // namespace

std::vector<PossibleMistake> geometric_mistakes(const Scanner& scanner, const Sequence& sequence) {
  std::vector<PossibleMistake> list;

  // 1. The other axis.
  const Axis axis = sequence.axis, other = across(axis);
  Sequence along_other = sequence;
  along_other.axis = other;

  add_geometric(list, CauseKind::axis,
                fmt::format("patterns that vary along {}, not {}", name_of(other), name_of(axis)),
                try_setting("axis", std::string(name_of(other))))
      .sequence = std::move(along_other);

  // 2. Pictures saved another way round.
  const auto pictures = [&](const PictureTurn& turn, const char* how, const char* advice) {
    add_geometric(list, CauseKind::picture_orientation,
                  fmt::format("pictures {} since the calibration", how), {advice})
        .turn = turn;
  };

  pictures({.columns = true, .rows = true}, "turned upside down",
           "rotate them by 180 degrees, or calibrate with pictures in this orientation");
  pictures({.columns = true}, "mirrored left to right", "mirror them back");
  pictures({.rows = true}, "mirrored top to bottom", "mirror them back");

  // 3. Scanner files.
  add_scanner_files(scanner, list);
  return list;
}

}  // namespace slipstream
