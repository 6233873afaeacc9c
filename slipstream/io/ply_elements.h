#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/io/number_reader.h"

namespace slipstream::ply {

/// A number, or a list of numbers, that each thing of an element has.
struct Property {
  std::string name;
  NumberType type = NumberType::float32;
  std::optional<NumberType> count_type;  ///< of a list
};

/// A kind of thing in the file, such as "vertex".
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

/// What the file holds, in order. Throws Error for what is no PLY file.
std::vector<Element> read_header(NumberReader& reader);

/// The numbers of one property: one, or as many as a list has.
std::vector<double> read_property(const Property& property, NumberReader& reader);

}  // namespace slipstream::ply
