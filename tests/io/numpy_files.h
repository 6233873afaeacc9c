// Files as NumPy writes them.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "base/numbers.h"

namespace slipstream {

/// Numbers in the order of the file, as numpy.save writes an array.
inline std::string npy_of(const std::vector<double>& numbers, const std::string& shape,
                          bool by_columns = false, const std::string& type = "<f8") {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': ({}), }}", type,
                                   by_columns ? "True" : "False", shape);
  header.append(127 - (10 + header.size()) % 64, ' ').push_back('\n');

  std::string file("\x93NUMPY\x01\x00", 8);
  append_numbers(file, static_cast<std::uint16_t>(header.size()));
  file += header;
  for (const double number : numbers) append_numbers(file, number);
  return file;
}

/// A matrix as numpy.save writes it.
inline std::string npy_of(const Eigen::MatrixXd& matrix, bool by_columns = false) {
  std::vector<double> numbers;
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    const Eigen::Index row = by_columns ? i % matrix.rows() : i / matrix.cols();
    const Eigen::Index column = by_columns ? i / matrix.rows() : i % matrix.cols();
    numbers.push_back(matrix(row, column));
  }
  return npy_of(numbers, fmt::format("{}, {}", matrix.rows(), matrix.cols()), by_columns);
}

/// A ZIP file as numpy.savez writes it; with `deflated` its files are in blocks of deflate, as
/// numpy.savez_compressed does.
inline std::string zip_of(const std::vector<std::pair<std::string, std::string>>& files,
                          bool deflated) {
  std::string zip, directory;
  const std::uint16_t version = 20, none = 0, method = deflated ? 8 : 0;

  for (const auto& [name, content] : files) {
    std::string packed = content;
    if (deflated) {
      const auto size = static_cast<std::uint16_t>(content.size());
      std::string block(1, '\x01');  // the last one, not compressed
      append_numbers(block, size, static_cast<std::uint16_t>(~size));
      packed = block + content;
    }

    const auto at = static_cast<std::uint32_t>(zip.size());
    const auto packed_size = static_cast<std::uint32_t>(packed.size());
    const auto size = static_cast<std::uint32_t>(content.size()), sum = std::uint32_t{0};
    const auto name_size = static_cast<std::uint16_t>(name.size());

    zip += "PK\x03\x04";
    append_numbers(zip, version, none, method, none, none, sum, packed_size, size, name_size, none);
    zip += name + packed;

    directory += "PK\x01\x02";
    append_numbers(directory, version, version, none, method, none, none, sum, packed_size, size,
                   name_size, none, none, none, none, std::uint32_t{0}, at);
    directory += name;
  }

  const auto start = static_cast<std::uint32_t>(zip.size());
  const auto count = static_cast<std::uint16_t>(files.size());
  zip += directory + "PK\x05\x06";
  append_numbers(zip, none, none, count, count, static_cast<std::uint32_t>(directory.size()), start,
                 none);
  return zip;
}

}  // namespace slipstream
