#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <type_traits>
#include <utility>

namespace slipstream {

/// Width and height of an image or a device's pixel grid.
struct Size {
  int width = 0;
  int height = 0;

  friend bool operator==(const Size&, const Size&) = default;
};

/// Calls `visit(column, row)` for every pixel, row by row.
template <class Visit>
void for_each_pixel_in_order(Size size, const Visit& visit) {
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) visit(column, row);
  }
}

/// Formats a size, e.g. "1824x1140".
inline std::string text_of(Size size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

/// A rectangle of an image or sensor: columns from x, rows from y.
struct Rectangle {
  int x = 0;
  int y = 0;
  Size size;
};

/// An 8-bit RGB pixel for the screen.
struct Colour {
  std::uint8_t red = 0, green = 0, blue = 0;

  friend bool operator==(const Colour&, const Colour&) = default;
};

using ColourMap = std::array<Colour, 256>;

/// Colour map for depth, in the viewer and in written pictures: red through yellow and green to
/// violet, so that near points stand out. Hue steps are even; yellow and cyan are no brighter than
/// necessary.
ColourMap depth_colours();

/// Cyclic hue map: 2 pi has the same colour as 0.
ColourMap phase_colours();

/// Crosstalk between the projector's red, green and blue and the camera's channels. Channel c of a
/// white surface is the sum over p of mixture[c][p] times the level that projector colour p alone
/// would give, plus mixture[c][3], the level without projector light, in grey levels of 255.
using ColourMixture = std::array<std::array<double, 4>, 3>;

/// Non-owning view of rows of `width` pixels, `stride` pixels apart; valid as long as the memory it
/// refers to. Pixel centres are at integer coordinates.
template <class Pixel>
class ImageView {
 public:
  ImageView() = default;
  ImageView(Pixel* pixels, Size size, std::ptrdiff_t stride)
      : pixels_(pixels), size_(size), stride_(stride) {}
  ImageView(Pixel* pixels, Size size) : ImageView(pixels, size, size.width) {}

  /// A writable view converts to a read-only one.
  operator ImageView<const Pixel>() const requires(!std::is_const_v<Pixel>) {
    return {pixels_, size_, stride_};
  }

  [[nodiscard]] int width() const { return size_.width; }
  [[nodiscard]] int height() const { return size_.height; }
  [[nodiscard]] Size size() const { return size_; }
  [[nodiscard]] std::ptrdiff_t stride() const { return stride_; }
  [[nodiscard]] Pixel* row(int row) const { return pixels_ + row * stride_; }
  Pixel& operator()(int column, int row) const { return pixels_[row * stride_ + column]; }

 private:
  Pixel* pixels_ = nullptr;
  Size size_;
  std::ptrdiff_t stride_ = 0;
};

struct Uninitialised {};
/// Tag for images that are fully written before they are read: skips the initial fill.
inline constexpr Uninitialised uninitialised;

/// Owned pixels, rows without gaps, the first aligned to 64 bytes. Copies are deep and reuse memory
/// of the same size.
template <class Pixel>
class Image {
 public:
  static_assert(std::is_trivially_copyable_v<Pixel>);

  Image() = default;
  explicit Image(Size size, Pixel value = {}) : pixels_(allocate(size)), size_(size) {
    std::fill(begin(), end(), value);
  }
  Image(Size size, Uninitialised) : pixels_(allocate(size)), size_(size) {}

  Image(const Image& other) : pixels_(allocate(other.size_)), size_(other.size_) {
    std::copy(other.begin(), other.end(), begin());
  }

  Image(Image&& other) noexcept
      : pixels_(std::move(other.pixels_)), size_(std::exchange(other.size_, Size{})) {}

  Image& operator=(const Image& other) {
    if (size_ != other.size_) return *this = Image(other);
    if (this != &other) std::copy(other.begin(), other.end(), begin());
    return *this;
  }

  Image& operator=(Image&& other) noexcept {
    std::swap(pixels_, other.pixels_);
    std::swap(size_, other.size_);
    return *this;
  }

  ~Image() = default;

  operator ImageView<Pixel>() { return {pixels_.get(), size_}; }
  operator ImageView<const Pixel>() const { return {pixels_.get(), size_}; }

  [[nodiscard]] int width() const { return size_.width; }
  [[nodiscard]] int height() const { return size_.height; }
  [[nodiscard]] Size size() const { return size_; }
  [[nodiscard]] std::size_t pixel_count() const { return count(size_); }
  [[nodiscard]] bool empty() const { return pixel_count() == 0; }

  [[nodiscard]] Pixel* row(int row) { return pixels_.get() + offset(row); }
  [[nodiscard]] const Pixel* row(int row) const { return pixels_.get() + offset(row); }
  Pixel& operator()(int column, int row) { return this->row(row)[column]; }
  const Pixel& operator()(int column, int row) const { return this->row(row)[column]; }

  [[nodiscard]] Pixel* begin() { return pixels_.get(); }
  [[nodiscard]] Pixel* end() { return pixels_.get() + pixel_count(); }
  [[nodiscard]] const Pixel* begin() const { return pixels_.get(); }
  [[nodiscard]] const Pixel* end() const { return pixels_.get() + pixel_count(); }

 private:
  static constexpr std::align_val_t alignment{64};

  struct Free {
    void operator()(Pixel* pixels) const { ::operator delete(pixels, alignment); }
  };

  using Storage = std::unique_ptr<Pixel[], Free>;

  static std::size_t count(Size size) {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  }

  static Storage allocate(Size size) {
    return Storage(static_cast<Pixel*>(::operator new(count(size) * sizeof(Pixel), alignment)));
  }

  [[nodiscard]] std::ptrdiff_t offset(int row) const {
    return static_cast<std::ptrdiff_t>(row) * size_.width;
  }

  Storage pixels_;
  Size size_;
};

/// Converts each pixel to the type of `to`, reusing its memory if the size matches.
template <class To, class From>
void convert(const Image<From>& from, Image<To>& to) {
  if (to.size() != from.size()) to = Image<To>(from.size());
  std::transform(from.begin(), from.end(), to.begin(),
                 [](From value) { return static_cast<To>(value); });
}

template <class To, class From>
Image<To> converted(const Image<From>& from) {
  Image<To> to;
  convert(from, to);
  return to;
}

}  // namespace slipstream
