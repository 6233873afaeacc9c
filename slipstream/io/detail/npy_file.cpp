#include "slipstream/io/detail/npy_file.h"

#include <algorithm>
#include <cstring>
#include <regex>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/error/number_text.h"
#include "slipstream/io/detail/number_bytes.h"
#include "slipstream/io/limits.h"

namespace slipstream {
namespace {

using namespace std::string_view_literals;
constexpr auto magic = "\x93NUMPY\x01\x00"sv;  // and the version, 1.0
constexpr std::size_t preamble = magic.size() + 2;

struct Shape {
  int rows = 0, columns = 0, type = CV_32F;

  [[nodiscard]] std::size_t bytes() const {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) *
           (type == CV_32F ? sizeof(float) : sizeof(double));
  }
};

Shape shape_in(const std::string& header) {
  static const std::regex known(
      R"(\{'descr': '<f([48])', 'fortran_order': False, 'shape': \((\d{1,9}), (\d{1,9})\), \} *\n)");
  std::smatch match;
  if (!std::regex_match(header, match, known)) {
    throw Error(
        "not rows x columns of little-endian float32 or float64; numpy.ascontiguousarray(map, "
        "dtype='<f4') is");
  }
  const auto side = [&](std::size_t i) { return number_in<int>(match[i].str()).value_or(0); };
  const auto pixels = static_cast<std::uint64_t>(side(2)) * static_cast<std::uint64_t>(side(3));
  if (pixels == 0 || pixels > largest_picture) {
    throw Error(
        fmt::format("says that it has {} pixels; 1 to {} are read", pixels, largest_picture));
  }
  return {side(2), side(3), match[1] == "4" ? CV_32F : CV_64F};
}

}  // namespace

cv::Mat read_npy(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t longest_header = 1024;
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.size() < preamble || !text.starts_with(magic))
    throw Error("not a NumPy file of version 1.0");
  const std::size_t length = bytes[magic.size()] + 256U * bytes[magic.size() + 1];
  if (length > longest_header || text.size() < preamble + length)
    throw Error("not a whole NumPy file");
  const Shape shape = shape_in(std::string(text.substr(preamble, length)));
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
  std::string file(magic);
  append_bytes(file, static_cast<std::uint16_t>(header.size()));
  file += header;
  const std::size_t numbers = mat.total() * mat.elemSize();
  std::vector<std::uint8_t> bytes(file.size() + numbers);
  std::copy(file.begin(), file.end(), bytes.begin());
  std::memcpy(bytes.data() + file.size(), mat.data, numbers);
  return bytes;
}

}  // namespace slipstream
