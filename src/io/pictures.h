#pragma once

#include <cstdint>
#include <variant>

#include "slipstream/image.h"

// Pictures of every format, from and to the bytes of a file: see compressed_pictures.h and
// plain_pictures.h. Their readers throw Error without a file name, and before allocating memory for
// more pixels than allowed for one of `frames` pictures. Their writers return no bytes for samples
// that their format does not support.
namespace slipstream {

struct PictureKind {
  Size size;         ///< in pixels
  int channels = 1;  ///< grey, RGB or RGBA
  int bits = 8;      ///< of a sample: 8 or 16, or float of 32 or 64

  [[nodiscard]] bool real() const { return bits > 16; }

  [[nodiscard]] std::size_t row_bytes() const {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(channels * bits / 8);
  }
};

/// Rows of samples.
struct Picture {
  /// Leaves the samples uninitialised.
  explicit Picture(const PictureKind& of);

  [[nodiscard]] std::uint8_t* row(int row);

  PictureKind kind;
  int used_bits = kind.bits;  ///< of the highest level that the file declares
  bool lossy = false;         ///< compressed as JPEG
  std::variant<Image<std::uint8_t>, Image<std::uint16_t>, Image<float>, Image<double>> samples;
};

/// A non-owning view of a Picture.
struct PictureView {
  template <class Sample>
  explicit PictureView(ImageView<const Sample> samples, int channels = 1)
      : kind{{samples.width() / channels, samples.height()}, channels, 8 * int{sizeof(Sample)}},
        first(reinterpret_cast<const std::uint8_t*>(samples.row(0))),
        stride(samples.stride() * std::ptrdiff_t{sizeof(Sample)}) {}

  template <class Sample>
  PictureView(const Image<Sample>& grey)  // NOLINT(google-explicit-constructor)
      : PictureView(ImageView<const Sample>(grey)) {}

  [[nodiscard]] const std::uint8_t* row(int row) const { return first + row * stride; }

  PictureKind kind;
  const std::uint8_t* first;
  std::ptrdiff_t stride;  ///< bytes
};

/// Throws Error if `pixels` exceeds the limit of one picture, or of `frames` frames of `bits`.
void require_readable(std::uint64_t pixels, std::size_t frames, int bits = 8);

/// Most bytes that deflate packs into one.
inline constexpr std::uint64_t deflate_factor = 1032;

/// Throws Error if a file is too short for its pixels, packed at most by this factor.
void require_held(std::uint64_t pixel_bytes, std::uint64_t file_bytes, std::uint64_t factor);

}  // namespace slipstream
