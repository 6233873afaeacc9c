#include "publish/genapi_features.h"

#include <fmt/format.h>

namespace slipstream {

void Features::node(const std::string& kind, const std::string& name, const std::string& content) {
  nodes_ += fmt::format("<{0} Name=\"{1}\">{2}</{0}>\n", kind, name, content);
}

void Features::show(const std::string& kind, const std::string& name, const std::string& content) {
  categories_.back().second += fmt::format("<pFeature>{}</pFeature>", name);
  node(kind, name, content);
}

void Features::keep(const std::string& kind, const std::string& name, GigeRegister where,
                    const std::string& access, const std::string& before,
                    const std::string& after) {
  node(kind, name + "Kept",
       fmt::format("<Address>0x{:X}</Address>{}<Length>4</Length><AccessMode>{}</AccessMode>"
                   "<pPort>Device</pPort><Cachable>NoCache</Cachable>{}<Endianess>BigEndian"
                   "</Endianess>",
                   static_cast<std::uint32_t>(where), before, access, after));
}

void Features::add(const std::string& kind, const std::string& name, GigeRegister where,
                   const std::string& access, const Around& around) {
  const auto& [before, after, selector] = around;
  // The feature reads and writes its register, one of several at steps of 4 bytes if selected.
  show(kind, name, fmt::format("{}<pValue>{}Kept</pValue>{}", before, name, after));
  std::string index;
  if (!selector.empty()) index = fmt::format("<pIndex Offset=\"4\">{}Kept</pIndex>", selector);

  const bool is_float = kind == "Float";
  keep(is_float ? "FloatReg" : "IntReg", name, where, access, index,
       is_float ? "" : unsigned_number);
}

void Features::constant(const std::string& name, const std::string& only) {
  show("Enumeration", name,
       fmt::format("<ImposedAccessMode>RO</ImposedAccessMode><EnumEntry Name=\"{}\"><Value>0"
                   "</Value></EnumEntry><Value>0</Value>",
                   only));
}

void Features::text(const std::string& name, std::uint32_t address, int length) {
  show("StringReg", name,
       fmt::format("<Address>0x{:X}</Address><Length>{}</Length><AccessMode>RO</AccessMode>"
                   "<pPort>Device</pPort>",
                   address, length));
}

void Features::part(const std::string& kind, const std::string& name, const std::string& bits,
                    const std::string& after) {
  show(kind, name, fmt::format("<pValue>{}Kept</pValue>{}", name, after));
  keep("MaskedIntReg", name, GigeRegister::packet_size, "RW", "", bits + unsigned_number);
}

void Features::command(const std::string& name, const std::string& kept, int value) {
  show("Command", name,
       fmt::format("<pValue>{}Kept</pValue><CommandValue>{}</CommandValue>", kept, value));
}

std::string Features::text() const {
  std::string root, text;
  for (const auto& [name, features] : categories_) {
    root += fmt::format("<pFeature>{}</pFeature>", name);
    text += fmt::format("<Category Name=\"{}\">{}</Category>\n", name, features);
  }
  return fmt::format("<Category Name=\"Root\">{}</Category>\n{}{}", root, text, nodes_);
}

std::string entry(std::string_view name, std::size_t value, const std::string& more) {
  return fmt::format("<EnumEntry Name=\"{}\">{}<Value>{}</Value></EnumEntry>", name, more, value);
}

std::string entries(std::initializer_list<const char*> names, std::size_t first) {
  std::string text;
  for (const char* name : names) text += entry(name, first++);
  return text;
}

std::string selects(std::initializer_list<const char*> features) {
  std::string text;
  for (const char* feature : features) text += fmt::format("<pSelected>{}</pSelected>", feature);
  return text;
}

}  // namespace slipstream
