#pragma once

#include "python/bindings/bindings.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream::python {

/// Keyword arguments, taken one by one.
class Keywords {
 public:
  explicit Keywords(const py::kwargs& given) : left_(given.attr("copy")()) {}

  /// Those that were given, by name: take("rate", rate, "loop", loop). Throws TypeError for what is
  /// no such value.
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
  /// The same of one that must be given.
  template <class Value>
  void need(const char* name, Value& value) {
    if (!left_.contains(name)) throw py::type_error(std::string(name) + " is missing");
    take(name, value);
  }
  /// Throws TypeError, and says what was meant, where any is left.
  void require_none_left() const;

 private:
  [[noreturn]] static void refuse(const char* name, const py::object& given);

  py::dict left_;
  std::vector<std::string> known_;
};

// Those of CleanSettings, ReconstructSettings and FringeOrderConsensus by the names they have
// there; of the second also `backend`, see set_backend, and `raw` for no cleaning and no range of
// depth.
void take(Keywords& keywords, CleanSettings& clean);
void take(Keywords& keywords, ReconstructSettings& settings);

/// Settings of keywords that say nothing else.
template <class Settings>
Settings settings_from(const py::kwargs& given) {
  Keywords keywords(given);
  Settings settings;
  take(keywords, settings);
  keywords.require_none_left();
  return settings;
}

/// By `scene` or `mesh`, `world`, `scanner` or `camera`, `ambient`, `noise_variance`,
/// `reflectivity`, `response`, `bits`, `seed`, `rays`, and how it moves from frame to frame:
/// `step`, mm, and `turn`, degrees about the upright axis.
VirtualWorld world_from(Keywords& keywords);

}  // namespace slipstream::python
