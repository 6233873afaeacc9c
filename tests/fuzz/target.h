#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/file.h"
#include "tests/fuzz/mutate.h"

namespace slipstream {

/// What takes bytes from outside, to be given any. `seeds` are whole and valid; `run` takes an
/// input in, throws Error where it refuses it, and anything else, or a crash, is a finding.
struct FuzzTarget {
  std::string name;
  std::function<std::vector<Bytes>()> seeds;
  std::function<void(std::span<const std::uint8_t>)> run;
  int cost = 1;  ///< of an input, as many others; that much fewer are tried by the tests

  /// Most bytes to allocate for an input, freed ones too: for each of its bytes, and besides.
  std::uint64_t bytes_each = 1000;
  std::uint64_t bytes_besides = 64 << 20;
};

std::vector<FuzzTarget>& fuzz_targets();

/// For the start of a program: `const bool known = add_fuzz_target({...});`
inline bool add_fuzz_target(FuzzTarget target) {
  fuzz_targets().push_back(std::move(target));
  return true;
}

/// The same, for a format whose inputs allocate more.
inline bool add_fuzz_target(FuzzTarget target, std::uint64_t bytes_each,
                            std::uint64_t bytes_besides = 64 << 20) {
  target.bytes_each = bytes_each;
  target.bytes_besides = bytes_besides;
  return add_fuzz_target(std::move(target));
}

/// Runs it; a refusal is fine if it is one line. Throws if it takes more memory than the target
/// allows, or ten seconds.
void run_fuzz_target(const FuzzTarget& target, std::span<const std::uint8_t> input);

Bytes bytes_of(const std::string& text);
std::string text_of_bytes(std::span<const std::uint8_t> bytes);

/// A file of that name in a folder of this process, in memory where there is one, holding `input`.
std::filesystem::path file_of(std::span<const std::uint8_t> input, const std::string& name);
/// The bytes of the file that `write` leaves at the path it is given, whose name ends in `name`.
Bytes written_file(const std::string& name,
                   const std::function<void(const std::filesystem::path&)>& write);

/// Numbers from an input, zeros when it is used up.
class InputNumbers {
 public:
  explicit InputNumbers(std::span<const std::uint8_t> input) : input_(input) {}

  template <class Number>
  Number next() {
    Number number{};
    const auto part = input_.first(std::min(sizeof(Number), input_.size()));
    std::copy(part.begin(), part.end(), reinterpret_cast<std::uint8_t*>(&number));
    input_ = input_.subspan(part.size());
    return number;
  }
  /// 0 to `end` - 1.
  int below(int end) { return next<std::uint16_t>() % end; }
  /// `least` to `most`.
  double between(double least, double most) {
    return least + (most - least) * next<std::uint16_t>() / 65535;
  }
  [[nodiscard]] std::span<const std::uint8_t> rest() const { return input_; }

 private:
  std::span<const std::uint8_t> input_;
};

}  // namespace slipstream
