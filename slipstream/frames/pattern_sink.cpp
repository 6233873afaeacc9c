#include "slipstream/frames/pattern_sink.h"

#include <fmt/format.h>

#include "slipstream/base/colour.h"
#include "slipstream/base/error.h"

namespace slipstream {

template <class Pixel>
void require_patterns(const std::vector<Image<Pixel>>& patterns, std::optional<Size> size,
                      const std::string& device) {
  if (patterns.empty()) throw Error("no pattern to be shown; one or more are wanted");
  const Size wanted = size.value_or(patterns.front().size());
  for (const Image<Pixel>& pattern : patterns) {
    if (pattern.size() == wanted) continue;
    throw Error(fmt::format("the patterns are {}x{}, but {} is {}x{}; each pixel must meet its own",
                            pattern.width(), pattern.height(), size ? device : "the first",
                            wanted.width, wanted.height));
  }
}

template void require_patterns(const std::vector<Image<std::uint8_t>>&, std::optional<Size>,
                               const std::string&);
template void require_patterns(const std::vector<Image<Colour>>&, std::optional<Size>,
                               const std::string&);

}  // namespace slipstream
