#include "slipstream/frame_source.h"

#include <numeric>
#include <string>
#include <string_view>

#include "base/names.h"
#include "base/throw_if-inl.h"
#include "slipstream/image.h"

namespace slipstream {
namespace {

constexpr std::array<std::string_view, 3> indexing_names{"source", "counted", "marker"};

}  // namespace

PatternIndexing pattern_indexing_named(std::string_view name) {
  if (name == "told") return PatternIndexing::source;  // its name up to version 0.2
  const auto indexing = value_named<PatternIndexing>(name, indexing_names);
  throw_if(!indexing, "indexing '{}' is unknown; use one of {}", name,
           fmt::join(indexing_names, ", "));
  return *indexing;
}

std::uint64_t byte_count(const FrameFormat& format) {
  const std::uint64_t bytes_per_pixel = format.bits > 8 ? 2 : 1;
  return bytes_per_pixel * format.size.width * format.size.height;
}

void require_valid(const FrameFormat& format) {
  const auto [width, height] = format.size;
  throw_if(width < 1 || height < 1, "frame size {}x{} is out of range; at least 1x1 pixels", width,
           height);
  throw_if(format.bits < 8 || format.bits > 16, "{} bits per pixel are out of range; 8 to 16",
           format.bits);
}

Frame::Frame(const FrameFormat& format) : bits(format.bits) {
  require_valid(format);
  pixels = bits == 8 ? decltype(pixels)(Image<std::uint8_t>(format.size))
                     : decltype(pixels)(Image<std::uint16_t>(format.size));
}

Temperatures temperatures_of(FrameSource& source) {
  const CameraControls* const controls = source.controls();
  return controls ? controls->temperatures() : Temperatures();
}

Reel reel_of(std::vector<Frame> frames) {
  std::vector<std::size_t> order(frames.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  return {.frames = std::move(frames), .order = std::move(order)};
}

template <class Pixel>
void require_patterns(const std::vector<Image<Pixel>>& patterns, std::optional<Size> size,
                      const std::string& device) {
  throw_if(patterns.empty(), "no patterns to show; at least one is required");

  const Size wanted = size.value_or(patterns.front().size());
  for (const Image<Pixel>& pattern : patterns) {
    throw_if(pattern.size() != wanted, "the patterns are {}, but {} is {}; the sizes must match",
             text_of(pattern.size()), size ? device : "the first", text_of(wanted));
  }
}

template void require_patterns(const std::vector<Image<std::uint8_t>>&, std::optional<Size>,
                               const std::string&);
template void require_patterns(const std::vector<Image<Colour>>&, std::optional<Size>,
                               const std::string&);

}  // namespace slipstream
