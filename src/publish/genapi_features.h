#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "devices/gige_protocol.h"

// The XML by which a GenICam camera describes its registers.
namespace slipstream {

/// XML elements around a node's value, in schema order, and its selector feature.
struct Around {
  std::string before{}, after{}, selector{};
};

inline constexpr const char* unsigned_number = "<Sign>Unsigned</Sign>";

/// Builds GenApi nodes, feature by feature.
class Features {
 public:
  void begin_category(const std::string& name) { categories_.emplace_back(name, ""); }

  void node(const std::string& kind, const std::string& name, const std::string& content);
  /// A visible node.
  void show(const std::string& kind, const std::string& name, const std::string& content);
  /// The register of a value.
  void keep(const std::string& kind, const std::string& name, GigeRegister where,
            const std::string& access, const std::string& before = "",
            const std::string& after = "");
  /// A feature backed by a register, writable if "RW".
  void add(const std::string& kind, const std::string& name, GigeRegister where,
           const std::string& access, const Around& around = {});
  void constant(const std::string& name, const std::string& only);
  void text(const std::string& name, std::uint32_t address, int length);
  /// Bits of the packet size register.
  void part(const std::string& kind, const std::string& name, const std::string& bits,
            const std::string& after);
  void command(const std::string& name, const std::string& kept, int value);

  [[nodiscard]] std::string text() const;

 private:
  std::string nodes_;
  std::vector<std::pair<std::string, std::string>> categories_;
};

std::string entry(std::string_view name, std::size_t value, const std::string& more = "");

/// Their values count up from `first`.
std::string entries(std::initializer_list<const char*> names, std::size_t first = 0);

std::string selects(std::initializer_list<const char*> features);

}  // namespace slipstream
