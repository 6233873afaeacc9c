#include "io/scan_scanner.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "geometry/lens_residual.h"
#include "slipstream/error.h"
#include "slipstream/recording.h"
#include "slipstream/scanner_file.h"

namespace slipstream {
namespace {

/// The lens for pictures each of whose pixels joins k by k of its own. Without a whole k that fits,
/// the same lens.
Lens binned(Lens lens, Size pictures) {
  if (pictures.width < 1 || pictures.height < 1) return lens;

  const int k = lens.size.width / pictures.width;
  const Size joined{lens.size.width / std::max(1, k), lens.size.height / std::max(1, k)};
  if (k < 2 || joined != pictures) return lens;

  // Pixel i joins pixels k i to k i + k - 1, whose middle is k i + (k - 1) / 2.
  lens.intrinsic(0, 2) -= (k - 1) / 2.0;
  lens.intrinsic(1, 2) -= (k - 1) / 2.0;
  lens.intrinsic.topRows<2>() /= k;
  lens.residual.centre.array() -= (k - 1) / 2.0;
  lens.residual = scaled(std::move(lens.residual), 1.0 / k);
  lens.size = pictures;
  return lens;
}

/// Throws Error if pictures look binned since the calibration and no region says so.
void require_unbinned(const Scanner& scanner, Size pictures, const ScanFiles& files) {
  const Size calibrated = scanner.camera.size;
  if (calibrated == pictures || binned(scanner.camera, pictures).size != pictures) return;

  throw Error(fmt::format(
      "{}: calibrated with pictures of {}, but the frames are {}; if the camera has joined pixels "
      "since, give the whole picture as `camera_region {}+0+0`",
      files.scanner->string(), text_of(calibrated), text_of(pictures), text_of(calibrated)));
}

}  // namespace

std::optional<Scanner> scanner_of(const ScanFiles& files) {
  if (files.recording && files.scanner == files.path) return files.recording->header().scanner;
  if (files.scanner) return read_scanner(*files.scanner);
  return std::nullopt;
}

void add_scanner(Scan& scan, std::optional<Scanner> scanner, const ScanFiles& files) {
  if (!scanner) return;

  const Size pictures = scan.frames.size();
  if (files.camera_region) {
    scanner->camera = binned(part_of(scanner->camera, *files.camera_region), pictures);
  } else {
    require_unbinned(*scanner, pictures, files);
  }

  scan.scanner =
      completed(*std::move(scanner), files.scanner->string(), pictures, files.sequence.projector);
  scan.sequence.projector = scan.scanner->projector.size;
}

}  // namespace slipstream
