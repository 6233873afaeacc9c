#include "slipstream/io/detail/npy_file.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/number_bytes.h"
#include "slipstream/base/number_text.h"
#include "slipstream/io/limits.h"

namespace slipstream {
namespace {

using namespace std::string_view_literals;
constexpr auto npy_magic = "\x93NUMPY\x01\x00"sv;  // and the version, 1.0
constexpr std::size_t preamble = npy_magic.size() + 2;

struct Shape {
  int rows = 0, columns = 0, type = CV_32F;

  [[nodiscard]] std::size_t bytes() const {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) *
           (type == CV_32F ? sizeof(float) : sizeof(double));
  }
};

/// What stands between the two, which are taken off the text's front with it; empty where they do
/// not stand there.
std::string_view take_between(std::string_view& text, std::string_view before,
                              std::string_view after) {
  const std::size_t end = text.find(after, before.size());
  if (!text.starts_with(before) || end == std::string_view::npos) return {};
  const std::string_view between = text.substr(before.size(), end - before.size());
  text.remove_prefix(end + after.size());
  return between;
}

Shape shape_in(std::string_view header) {
  const std::string_view size = take_between(header, "{'descr': '<f", "'");
  const auto rows =
      number_in<int>(take_between(header, ", 'fortran_order': False, 'shape': (", ", "));
  const auto columns = number_in<int>(take_between(header, "", "), }"));
  const bool ends = header.find_first_not_of(' ') == header.size() - 1 && header.ends_with('\n');
  if ((size != "4" && size != "8") || !rows || !columns || !ends) {
    throw Error(
        "not rows x columns of little-endian float32 or float64; numpy.ascontiguousarray(map, "
        "dtype='<f4') is");
  }
  const std::int64_t pixels =
      *rows < 0 || *columns < 0 ? 0 : static_cast<std::int64_t>(*rows) * *columns;
  if (pixels == 0 || pixels > static_cast<std::int64_t>(largest_picture)) {
    throw Error(
        fmt::format("says that it has {} pixels; 1 to {} are read", pixels, largest_picture));
  }
  return {*rows, *columns, size == "4" ? CV_32F : CV_64F};
}

}  // namespace

cv::Mat read_npy(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t longest_header = 1024;
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.size() < preamble || !text.starts_with(npy_magic))
    throw Error("not a NumPy file of version 1.0");
  const std::size_t length = bytes[npy_magic.size()] + 256U * bytes[npy_magic.size() + 1];
  if (length > longest_header || text.size() < preamble + length)
    throw Error("not a whole NumPy file");
  const Shape shape = shape_in(text.substr(preamble, length));
  const std::string_view numbers = text.substr(preamble + length);
  if (numbers.size() != shape.bytes()) {
    throw Error(
        fmt::format("has {} bytes of numbers; its shape says {}", numbers.size(), shape.bytes()));
  }
  cv::Mat mat(shape.rows, shape.columns, shape.type);
  std::memcpy(mat.data, numbers.data(), numbers.size());
  return mat;
}

std::vector<std::uint8_t> npy_file_of(const cv::Mat& mat) {
  std::string header =
      fmt::format("{{'descr': '<f{}', 'fortran_order': False, 'shape': ({}, {}), }}",
                  mat.elemSize(), mat.rows, mat.cols);
  constexpr std::size_t block = 64;  // what is before the numbers fills so many bytes, or twice
  header.append(block - 1 - (preamble + header.size()) % block, ' ').push_back('\n');
  std::string file(npy_magic);
  append_numbers(file, static_cast<std::uint16_t>(header.size()));
  file += header;
  const std::size_t numbers = mat.total() * mat.elemSize();
  std::vector<std::uint8_t> bytes(file.size() + numbers);
  std::copy(file.begin(), file.end(), bytes.begin());
  std::memcpy(bytes.data() + file.size(), mat.data, numbers);
  return bytes;
}

}  // namespace slipstream
