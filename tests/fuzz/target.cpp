#include "tests/fuzz/target.h"

#include <cstdint>
#include <ctime>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "io/file.h"
#include "slipstream/error.h"
#include "tests/fuzz/allocated.h"
#include "tests/io/temporary_folder.h"

namespace slipstream {
namespace fs = std::filesystem;

std::vector<FuzzTarget>& fuzz_targets() {
  static std::vector<FuzzTarget> targets;
  return targets;
}

namespace {

/// Throws if an input costs more than in proportion to its bytes.
void require_cheap(const FuzzTarget& target, std::size_t input, std::uint64_t bytes,
                   double seconds) {
  constexpr double most_seconds = 10;  // of the processor; inputs take milliseconds
  const std::uint64_t most = target.bytes_besides + target.bytes_each * input;

  if (bytes > most) {
    throw std::logic_error(
        fmt::format("allocated {} bytes for an input of {}; limit {}", bytes, input, most));
  }
  if (seconds > most_seconds) {
    throw std::logic_error(fmt::format("took {:.1f} s for an input of {}", seconds, input));
  }
}

}  // namespace

void run_fuzz_target(const FuzzTarget& target, std::span<const std::uint8_t> input) {
  const std::uint64_t before = allocated_bytes();
  const std::clock_t start = std::clock();

  try {
    target.run(input);
  } catch (const Error& error) {
    const std::string text = error.what();
    if (text.find('\n') != std::string::npos) throw std::logic_error("not one line: " + text);
  }

  require_cheap(target, input.size(), allocated_bytes() - before,
                static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
}

Bytes bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}

std::string text_of_bytes(std::span<const std::uint8_t> bytes) {
  return {bytes.begin(), bytes.end()};
}

namespace {

const fs::path& work_folder() {
  static const TemporaryFolder folder(fs::exists("/dev/shm") ? "/dev/shm"
                                                             : fs::temp_directory_path());
  return folder.path();
}

}  // namespace

fs::path file_of(std::span<const std::uint8_t> input, const std::string& name) {
  fs::path path = work_folder() / name;
  put_bytes(path, input);
  return path;
}

Bytes written_file(const std::string& name, const std::function<void(const fs::path&)>& write) {
  const fs::path path = work_folder() / ("seed-" + name);
  write(path);
  return read_file(path);
}

}  // namespace slipstream
