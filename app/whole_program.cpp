#include "app/whole_program.h"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <elf.h>
#include <fmt/format.h>
#include <link.h>
#include <unistd.h>

#include "io/file.h"

namespace slipstream::app {

// Made at build time, see version.cmake; in a section of its own.
extern const char program_mark[];

namespace {

constexpr std::string_view mark_section = ".slipstream";

template <class Value>
std::span<std::uint8_t> memory_of(Value* values, std::size_t count) {
  return {reinterpret_cast<std::uint8_t*>(values), count * sizeof(Value)};
}

/// The contents of a section; empty if the file ends before.
std::string contents_of(const InputFile& file, const ElfW(Shdr) & section) {
  if (section.sh_type == SHT_NOBITS || section.sh_size > largest_text) return {};
  std::string text(section.sh_size, '\0');
  return file.read(section.sh_offset, {memory_of(text.data(), text.size())}) ? text : "";
}

}  // namespace

std::string mark_of(const std::filesystem::path& program) {
  // 1. The header of a program, and the list of its sections.
  const InputFile file(program, no_limit);
  ElfW(Ehdr) header{};
  const bool is_program = file.read(0, {memory_of(&header, 1)}) &&
                          std::memcmp(header.e_ident, ELFMAG, SELFMAG) == 0 &&
                          header.e_shentsize == sizeof(ElfW(Shdr));
  if (!is_program) return {};

  std::vector<ElfW(Shdr)> sections(header.e_shnum);
  const bool has_sections =
      file.read(header.e_shoff, {memory_of(sections.data(), sections.size())});
  if (!has_sections || header.e_shstrndx >= sections.size()) return {};

  // 2. The section by its name. A text ends with 0.
  const std::string names = contents_of(file, sections[header.e_shstrndx]);
  for (const ElfW(Shdr) & section : sections) {
    if (section.sh_name >= names.size()) continue;
    if (names.c_str() + section.sh_name == mark_section) return contents_of(file, section).c_str();
  }
  return {};
}

std::string run_whole_program(char* const* arguments) {
  std::error_code unknown;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", unknown).parent_path();

  for (const char* const place : {"whole/slipstream", "../libexec/slipstream/slipstream"}) {
    const std::filesystem::path program = folder / place;
    try {
      if (mark_of(program) != program_mark) continue;
      ::execv(program.c_str(), arguments);
      return fmt::format("cannot run {}: {}", program.string(), std::strerror(errno));
    } catch (const std::exception&) {
      // No such file, or not a readable one.
    }
  }

  return fmt::format(
      "this command is in a second program of the same version, {0}/whole/slipstream or "
      "{0}/../libexec/slipstream/slipstream, which is not there; copy both programs, or make a "
      "link to the installed one",
      folder.string());
}

}  // namespace slipstream::app
