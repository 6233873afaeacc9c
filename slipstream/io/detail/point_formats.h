#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/cloud/surface.h"
#include "slipstream/io/cloud_file.h"

namespace slipstream {

enum class NumberType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

enum class NumberFormat { ascii, little_endian, big_endian };

/// Takes lines and numbers off the front of a file of points, never past its end. Throws Error,
/// which does not name the file, where it ends too soon.
class NumberReader {
 public:
  explicit NumberReader(std::span<const std::uint8_t> bytes)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}

  std::string_view line();
  double number(NumberType type);
  /// Of the numbers to come; ASCII before.
  void set_format(NumberFormat format);
  /// What is not yet read: no element has more numbers than that has bytes.
  [[nodiscard]] std::string_view left() const { return text_; }

 private:
  double ascii_number();
  template <class Stored>
  double binary_number();

  std::string_view text_;
  bool ascii_ = true;
  bool swapped_ = false;
};

/// What stands between blanks.
std::vector<std::string_view> words_of(std::string_view line);

/// The number of things that a word says. Throws Error for any other word.
std::size_t count_from(std::string_view text);

/// A number, or a list of numbers, that each thing of an element of a PLY file has.
struct PlyProperty {
  std::string name;
  NumberType type = NumberType::float32;
  std::optional<NumberType> count_type{};  ///< of a list
};

/// A kind of thing in a PLY file, such as "vertex".
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties{};
};

/// What a PLY file holds, in order. Throws Error for what is no PLY file.
std::vector<PlyElement> read_ply_header(NumberReader& reader);

/// How the intensity is declared in PLY. MeshLab takes an intensity of 32-bit float for a grey of 0
/// to 1 and paints the points white with it, over their red, green and blue; of a double it knows
/// nothing.
inline constexpr const char* ply_intensity = "property double intensity\n";

/// A binary glTF 2.0 file, as write_surface says.
std::string glb_file(const Surface& surface);

/// The vertices of such a file, in the camera's frame, mm. Throws Error, which does not name the
/// file, for what is no such file or ends too soon.
StoredPoints glb_points(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
