// NumPy's .npz: a ZIP file of .npy files.
#include "io/npz_file.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <libdeflate.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"

namespace slipstream {
namespace {

using NpzBytes = std::span<const std::uint8_t>;

std::string_view characters_in(NpzBytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// `length` bytes at `at`. Throws Error if they are not there.
NpzBytes part_of(NpzBytes bytes, std::size_t at, std::size_t length) {
  throw_if(at > bytes.size() || length > bytes.size() - at, "not a complete NumPy file");
  return bytes.subspan(at, length);
}

/// Bytes that a file in the ZIP file takes, unpacked or packed, from its entry in the directory.
std::uint64_t size_of_file(NpzBytes entry) {
  return std::max(number_at<std::uint32_t>(entry, 20), number_at<std::uint32_t>(entry, 24));
}

/// The bytes of a file in the ZIP file, from its entry in the directory.
std::vector<std::uint8_t> unpacked_file(NpzBytes bytes, NpzBytes entry) {
  constexpr std::size_t local_header = 30;
  constexpr int stored = 0, deflated = 8;
  const auto method = number_at<std::uint16_t>(entry, 10);
  const std::size_t packed_size = number_at<std::uint32_t>(entry, 20);
  const std::size_t size = number_at<std::uint32_t>(entry, 24);

  // 1. The data follow a header of their own.
  const std::size_t at = number_at<std::uint32_t>(entry, 42);
  const NpzBytes header = part_of(bytes, at, local_header);
  const std::size_t names =
      std::size_t{number_at<std::uint16_t>(header, 26)} + number_at<std::uint16_t>(header, 28);
  const NpzBytes packed = part_of(bytes, at + local_header + names, packed_size);

  // 2. Unpack.
  if (method == stored) return {packed.begin(), packed.end()};
  throw_if(method != deflated, "is packed in an unknown way; write it with numpy.savez");

  std::vector<std::uint8_t> unpacked(size);
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> unpacker(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  const bool good =
      unpacker != nullptr &&
      libdeflate_deflate_decompress(unpacker.get(), packed.data(), packed.size(), unpacked.data(),
                                    size, nullptr) == LIBDEFLATE_SUCCESS;
  throw_if(!good, "not a complete NumPy file");
  return unpacked;
}

/// The text between `begin` and `end`; empty without them.
std::string_view text_between(std::string_view text, std::string_view begin, std::string_view end) {
  const std::size_t at = text.find(begin);
  if (at == text.npos) return {};
  text.remove_prefix(at + begin.size());
  return text.substr(0, std::min(text.find(end), text.size()));
}

/// The lengths in a shape such as "12, 147, 2" or "5,"; 1 for "", none for other texts.
std::vector<int> lengths_in_shape(std::string_view shape) {
  std::vector<int> lengths;

  while (!shape.empty()) {
    std::string_view word = take_until(shape, ',');
    word.remove_prefix(std::min(word.find_first_not_of(' '), word.size()));
    if (word.empty()) continue;

    const auto length = number_in<int>(word);
    if (!length || *length < 0) return {};
    lengths.push_back(*length);
  }

  return lengths.empty() ? std::vector{1} : lengths;
}

/// Where the file of an array ordered by columns has number `i` of the array ordered by rows.
std::size_t place_by_columns(std::size_t i, const std::vector<int>& shape) {
  std::size_t place = 0;
  for (std::size_t axis = shape.size(); axis-- > 0;) {
    std::size_t stride = 1;
    for (std::size_t before = 0; before < axis; ++before) stride *= shape[before];

    place += i % shape[axis] * stride;
    i /= shape[axis];
  }
  return place;
}

/// Number `i` of an array of that type; nullopt for other types.
std::optional<double> number_of_type(NpzBytes numbers, std::string_view type, std::size_t i) {
  const auto as = [&]<class Number>(Number) -> std::optional<double> {
    if (numbers.size() / sizeof(Number) <= i) return std::nullopt;
    return static_cast<double>(number_at<Number>(numbers, i * sizeof(Number)));
  };

  if (type == "<f8") return as(double{});
  if (type == "<f4") return as(float{});
  if (type == "<i8") return as(std::int64_t{});
  if (type == "<i4") return as(std::int32_t{});
  if (type == "<u2") return as(std::uint16_t{});
  return std::nullopt;
}

/// An array as a matrix: a list is a row. Empty for arrays of more dimensions, and large ones.
StoredMatrix matrix_of(const NumpyArray& array) {
  constexpr int most = 4096;
  const std::vector<int>& shape = array.shape;
  if (array.numbers.empty() || shape.size() > 2 || std::ranges::max(shape) > most) return {};
  return {shape.size() == 2 ? shape.front() : 1, shape.back(), array.numbers};
}

}  // namespace

std::optional<NpyHeader> npy_header(NpzBytes file) {
  if (file.size() < npy_preamble || !characters_in(file).starts_with(npy_magic)) return {};

  // A Python dictionary in the form that numpy.save writes.
  const std::size_t length = number_at<std::uint16_t>(file, npy_magic.size());
  const std::string_view header = characters_in(part_of(file, npy_preamble, length));
  return NpyHeader{.type = text_between(header, "'descr': '", "'"),
                   .by_columns = text_between(header, "'fortran_order': ", ",").starts_with("True"),
                   .shape = lengths_in_shape(text_between(header, "'shape': (", ")")),
                   .numbers = file.subspan(npy_preamble + length)};
}

NumpyArray array_of_npy(NpzBytes file) {
  const auto header = npy_header(file);
  if (!header) return {};

  // Larger arrays than a calibration has are left out.
  constexpr double most = 1 << 24;
  NumpyArray array{.shape = header->shape, .has_objects = header->type == "|O"};
  double count = array.shape.empty() ? 0 : 1;
  for (const int each : array.shape) count *= each;
  if (count == 0 || count > most) return {.has_objects = array.has_objects};

  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const auto number = number_of_type(header->numbers, header->type,
                                       header->by_columns ? place_by_columns(i, array.shape) : i);
    if (!number) return {.has_objects = array.has_objects};
    array.numbers.push_back(*number);
  }
  return array;
}

std::map<std::string, NumpyArray> arrays_of_npz(NpzBytes bytes, std::uint64_t largest) {
  // 1. The end of the file names the place of the directory.
  constexpr std::size_t end_size = 22, entry_size = 46;
  const std::size_t end = characters_in(bytes).rfind("PK\x05\x06");
  throw_if(end == std::string_view::npos, "not a complete NumPy file");

  const NpzBytes ending = part_of(bytes, end, end_size);
  const std::size_t count = number_at<std::uint16_t>(ending, 10);
  std::size_t at = number_at<std::uint32_t>(ending, 16);

  // 2. The files that the directory lists.
  constexpr std::size_t most = 4096;
  constexpr std::uint64_t largest_sum = 64 * largest_text;
  throw_if(count > most, "has {} arrays; at most {} are read", count, most);
  std::map<std::string, NumpyArray> arrays;
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const NpzBytes entry = part_of(bytes, at, entry_size);
    throw_if(!characters_in(entry).starts_with("PK\x01\x02"), "not a complete NumPy file");

    const std::size_t name_size = number_at<std::uint16_t>(entry, 28);
    std::string name(characters_in(part_of(bytes, at + entry_size, name_size)));
    if (name.ends_with(".npy")) name.resize(name.size() - 4);

    // Entries may share packed bytes, so their sizes count, not the file's.
    const std::uint64_t size = size_of_file(entry);
    const bool is_small = size <= largest;
    if (is_small) sum += size;
    throw_if(sum > largest_sum, "its arrays have more than {} MiB together",
             largest_sum / largest_text);
    arrays[name] = is_small ? array_of_npy(unpacked_file(bytes, entry)) : NumpyArray();

    at += entry_size + name_size + number_at<std::uint16_t>(entry, 30) +
          number_at<std::uint16_t>(entry, 32);
  }
  return arrays;
}

StoredEntries npz_arrays(NpzBytes bytes) {
  // Larger arrays, such as the corners of the boards, do not belong to the calibration.
  StoredEntries matrices;
  for (const auto& [name, array] : arrays_of_npz(bytes, largest_text)) {
    matrices[name] = matrix_of(array);
  }
  return matrices;
}

}  // namespace slipstream
