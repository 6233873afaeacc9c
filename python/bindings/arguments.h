#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "python/bindings/bindings.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"

namespace slipstream::python {

/// A copy of an array, rows x columns. Throws Error for other shapes.
Image<float> image_from(const ArrayOf<float>& array);

/// Borrowed frames, and the object that keeps them alive.
struct BorrowedFrames {
  std::vector<py::object> owners;
  FrameViews views;
};

/// Takes `Frames`, one array frames x rows x columns, or a list of arrays rows x columns: uint8,
/// uint16 of `bits` (default 16), float64 or float32. Copies only float32. `count`: the expected
/// number, to say which axis of an array has it; 0: any. Throws Error if a row's pixels are not
/// contiguous or the arrays are not frames.
BorrowedFrames borrowed(const py::object& frames, std::optional<int> bits, int count = 0);

/// Throws Error if the frames would fit the camera with width and height exchanged.
void require_upright(Size frames, Size camera);

/// A value in one line for messages: of an array its shape and type, of others their repr, cut
/// short.
std::string shown(const py::handle& value);

/// Keyword arguments, taken one by one.
class Keywords {
 public:
  explicit Keywords(const py::kwargs& kwargs);

  /// Takes given keywords by name: take("rate", rate, "loop", loop). Throws TypeError for a value
  /// of the wrong type.
  template <class Value, class... More>
  void take(const char* name, Value& value, More&... more) {
    known_.emplace_back(name);

    if (left_.contains(name)) {
      const py::object given = left_.attr("pop")(name);
      try {
        value = given.cast<Value>();
      } catch (const py::cast_error&) {
        refuse(name, given);
      }
    }

    if constexpr (sizeof...(more) > 0) take(more...);
  }

  /// Takes a required keyword.
  template <class Value>
  void need(const char* name, Value& value) {
    if (!left_.contains(name)) throw py::type_error(std::string(name) + " is missing");
    take(name, value);
  }

  /// Throws TypeError with a suggestion if any keyword is left.
  void require_none_left() const;

 private:
  [[noreturn]] static void refuse(const char* name, const py::object& given);

  py::dict left_;
  std::vector<std::string> known_;
};

// Takes the members of CleanSettings, ReconstructSettings and FringeOrderConsensus by name; also
// `backend`, see set_backend, and `raw` for no cleaning and no depth range.
void take(Keywords& keywords, CleanSettings& clean);
void take(Keywords& keywords, ReconstructSettings& settings);

/// "camera_bits" of "camera-bits".
std::string keyword_of(std::string_view option);

/// Takes the settings that a struct describes, see Setting, by their names and those of the
/// program.
template <class Settings>
void take_described(Keywords& keywords, Settings& settings) {
  Settings::for_each_setting(settings, [&](const Setting& setting, auto& value) {
    using Value = std::remove_reference_t<decltype(value)>;

    if constexpr (std::is_same_v<Value, std::optional<PointBox>>) {
      using Corner = std::array<double, 3>;
      std::optional<std::pair<Corner, Corner>> box;
      keywords.take(setting.name, box);
      if (box) value = PointBox{box->first, box->second};
    } else if constexpr (std::is_same_v<Value, std::vector<PictureCorner>>) {
      std::vector<std::pair<double, double>> corners;
      keywords.take(setting.name, corners);
      for (const auto& [column, row] : corners) value.push_back({column, row});
    } else {
      keywords.take(setting.name, value);

      // The program's name, e.g. "virtual_noise", where another setting has the short one.
      const std::string option = keyword_of(setting.option);
      if (!option.empty() && option != setting.name && !setting.option_clears) {
        keywords.take(option.c_str(), value);
      }
    }
  });
}

/// Settings from keywords. Throws TypeError if a keyword is left.
template <class Settings>
Settings settings_from(const py::kwargs& kwargs) {
  Keywords keywords(kwargs);
  Settings settings;
  take(keywords, settings);

  keywords.require_none_left();
  return settings;
}

}  // namespace slipstream::python
