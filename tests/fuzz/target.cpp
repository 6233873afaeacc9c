#include "tests/fuzz/target.h"

#include <filesystem>
#include <stdexcept>

#include "io/file.h"
#include "slipstream/error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream {
namespace fs = std::filesystem;

std::vector<FuzzTarget>& fuzz_targets() {
  static std::vector<FuzzTarget> targets;
  return targets;
}

void run_fuzz_target(const FuzzTarget& target, std::span<const std::uint8_t> input) {
  try {
    target.run(input);
  } catch (const Error& error) {
    const std::string text = error.what();
    if (text.find('\n') != std::string::npos) throw std::logic_error("not one line: " + text);
  }
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
