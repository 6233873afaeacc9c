#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace slipstream::ply {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// A number, or a list of numbers, that each thing of an element has.
struct Property {
  std::string name;
  Type type = Type::float32;
  std::optional<Type> count_type;  ///< of a list
};

/// A kind of thing in the file, such as "vertex".
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

/// Takes words, lines and numbers off the front of a PLY file, never past its end. Throws Error,
/// which does not name the file, where it ends too soon.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}

  std::string_view line();
  double number(Type type);
  /// "ascii", "binary_little_endian" or "binary_big_endian"; throws Error for another.
  void set_format(std::string_view format);
  /// Bytes not yet read: no element has more numbers than that.
  [[nodiscard]] std::size_t left() const { return text_.size(); }

 private:
  double ascii_number();
  template <class Stored>
  double binary_number();

  std::string_view text_;
  bool ascii_ = true;
  bool swapped_ = false;
};

/// What the file holds, in order. Throws Error for what is no PLY file.
std::vector<Element> read_header(Reader& reader);

/// The numbers of one property: one, or as many as a list has.
std::vector<double> read_property(const Property& property, Reader& reader);

}  // namespace slipstream::ply
