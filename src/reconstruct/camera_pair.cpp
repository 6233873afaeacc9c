#include "reconstruct/camera_pair.h"

#include <cstdint>
#include <string_view>

#include "base/throw_if-inl.h"
#include "reconstruct/fused/rows.h"

namespace slipstream {

void require_pair(const Scanner& first, const Scanner& second, const PhaseMatchSettings& match) {
  require_valid(first);
  require_valid(second);
  throw_if(first.projector.size != second.projector.size ||
               !first.projector.intrinsic.isApprox(second.projector.intrinsic),
           "the two cameras' scanners have different projectors; both must have the same");

  // The difference is the second camera's position in the first one's frame, mm.
  throw_if((projector_centre(first) -
            first.rotation.transpose() * second.rotation * projector_centre(second))
                   .norm() < 1e-9,
           "the two cameras are in the same place and measure no depth; check their translations");

  for (const Scanner* const scanner : {&first, &second}) {
    const Size size = scanner->camera.size;
    const std::int64_t pixels = std::int64_t{size.width} * size.height;
    throw_if(size.width < 2 || size.height < 2 || pixels < least_row_width,
             "pictures of {} are too small to be matched", text_of(size));
  }

  throw_if(match.window < 0 || match.window > 100,
           "match window {} is out of range; 0 to 100 pixels", match.window);
}

void require_size(const FrameViews& frames, const Scanner& scanner, std::string_view which) {
  throw_if(frames.size() != scanner.camera.size,
           "frames of the {} camera are {}, its scanner says {}; both must agree", which,
           text_of(frames.size()), text_of(scanner.camera.size));
}

}  // namespace slipstream
