#include "slipstream/io/detail/png_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <new>
#include <string>

#include <png.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace {

/// What libpng reads from, and why it could not.
struct Source {
  std::span<const std::uint8_t> left;
  std::array<char, 80> fault{};
};

void take(png_structp png, png_bytep to, std::size_t count) {
  auto& left = static_cast<Source*>(png_get_io_ptr(png))->left;
  if (count > left.size()) png_error(png, "truncated");
  std::copy_n(left.begin(), count, to);
  left = left.subspan(count);
}

[[noreturn]] void refuse(png_structp png, png_const_charp why) {
  auto& fault = static_cast<Source*>(png_get_error_ptr(png))->fault;
  std::string_view(why).copy(fault.data(), fault.size() - 1);
  png_longjmp(png, 1);
}

void ignore(png_structp, png_const_charp) {}

/// libpng's own memory for one file.
struct Reader {
  explicit Reader(Source& source)
      : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, refuse, ignore)),
        info(png_create_info_struct(png)) {
    png_set_read_fn(png, &source, take);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }

  png_structp png;
  png_infop info;
};

/// False where libpng refuses: it jumps back to here, past nothing that has a destructor.
bool read_into(cv::Mat& mat, png_structp png, png_infop info) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  png_read_info(png, info);
  png_set_palette_to_rgb(png);
  png_set_expand_gray_1_2_4_to_8(png);
  png_set_strip_alpha(png);
  png_set_bgr(png);
  if (std::endian::native == std::endian::little) png_set_swap(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  const int depth = png_get_bit_depth(png, info) == 16 ? CV_16U : CV_8U;
  mat.create(static_cast<int>(png_get_image_height(png, info)),
             static_cast<int>(png_get_image_width(png, info)),
             CV_MAKETYPE(depth, png_get_channels(png, info)));
  for (int pass = 0; pass < passes; ++pass) {
    for (int row = 0; row < mat.rows; ++row) png_read_row(png, mat.ptr(row), nullptr);
  }
  png_read_end(png, nullptr);
  return true;
}

}  // namespace

bool is_png(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 8 && png_sig_cmp(bytes.data(), 0, 8) == 0;
}

cv::Mat read_png(std::span<const std::uint8_t> bytes) {
  Source source{.left = bytes};
  const Reader reader(source);
  if (reader.info == nullptr) throw std::bad_alloc();
  cv::Mat mat;
  if (!read_into(mat, reader.png, reader.info)) {
    throw Error(std::string("not a whole PNG file: ") + source.fault.data());
  }
  return mat;
}

}  // namespace slipstream
