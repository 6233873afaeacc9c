#include "slipstream/publish/detail/scan3d_description.h"

#include <initializer_list>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "slipstream/gige/gige_block.h"

namespace slipstream {
namespace {

struct Entry {
  std::string name;
  std::uint32_t value;
  std::string more = "";  ///< elements before its value
};

/// Nodes of GenApi, feature by feature.
class Features {
 public:
  void begin_category(const std::string& name) { categories_.emplace_back(name, ""); }

  /// A node that is shown; `content`: its elements, in the order of the schema.
  void add(const std::string& kind, const std::string& name, const std::string& content) {
    categories_.back().second += fmt::format("<pFeature>{}</pFeature>", name);
    node(kind, name, content);
  }
  void node(const std::string& kind, const std::string& name, const std::string& content) {
    nodes_ += fmt::format("<{0} Name=\"{1}\">{2}</{0}>\n", kind, name, content);
  }
  /// Where a value is kept; `selector`: the feature that says which of several.
  void keep(const std::string& kind, const std::string& name, std::uint32_t address,
            const std::string& access, const std::string& selector = "") {
    std::string index;
    if (!selector.empty()) index = fmt::format("<pIndex Offset=\"4\">{}Kept</pIndex>", selector);
    node(kind, name + "Kept",
         fmt::format("<Address>0x{:X}</Address>{}<Length>4</Length><AccessMode>{}</AccessMode>"
                     "<pPort>Device</pPort><Cachable>NoCache</Cachable>{}<Endianess>BigEndian"
                     "</Endianess>",
                     address, index, access, kind == "IntReg" ? "<Sign>Unsigned</Sign>" : ""));
  }
  void integer(const std::string& name, GigeRegister where, const std::string& access,
               const std::string& limits = "", const std::string& selector = "") {
    add("Integer", name, fmt::format("<pValue>{}Kept</pValue>{}", name, limits));
    keep("IntReg", name, static_cast<std::uint32_t>(where), access, selector);
  }
  void constant(const std::string& name, std::int64_t value) {
    add("Integer", name,
        fmt::format("<ImposedAccessMode>RO</ImposedAccessMode><Value>{}</Value>", value));
  }
  void number(const std::string& name, GigeRegister where, const std::string& access,
              const std::string& selector = "") {
    add("Float", name, fmt::format("<pValue>{}Kept</pValue>", name));
    keep("FloatReg", name, static_cast<std::uint32_t>(where), access, selector);
  }
  void command(const std::string& name, const std::string& kept, int value) {
    add("Command", name,
        fmt::format("<pValue>{}Kept</pValue><CommandValue>{}</CommandValue>", kept, value));
  }
  void text(const std::string& name, std::uint32_t address, int length) {
    add("StringReg", name,
        fmt::format("<Address>0x{:X}</Address><Length>{}</Length><AccessMode>RO</AccessMode>"
                    "<pPort>Device</pPort>",
                    address, length));
  }
  void choice(const std::string& name, std::initializer_list<Entry> entries, GigeRegister where,
              const std::string& access, const std::string& selector = "",
              const std::string& selected = "") {
    add("Enumeration", name,
        fmt::format("{}<pValue>{}Kept</pValue>{}", text_of(entries), name, selected));
    keep("IntReg", name, static_cast<std::uint32_t>(where), access, selector);
  }
  void choice(const std::string& name, const std::string& only) {
    add("Enumeration", name,
        fmt::format("<ImposedAccessMode>RO</ImposedAccessMode>{}<Value>0</Value>",
                    text_of({{only, 0}})));
  }

  [[nodiscard]] std::string text() const {
    std::string root, text;
    for (const auto& [name, features] : categories_) {
      root += fmt::format("<pFeature>{}</pFeature>", name);
      text += fmt::format("<Category Name=\"{}\">{}</Category>\n", name, features);
    }
    return fmt::format("<Category Name=\"Root\">{}</Category>\n{}{}", root, text, nodes_);
  }

 private:
  static std::string text_of(std::initializer_list<Entry> entries) {
    std::string text;
    for (const auto& [name, value, more] : entries) {
      text +=
          fmt::format("<EnumEntry Name=\"{}\">{}<Value>{}</Value></EnumEntry>", name, more, value);
    }
    return text;
  }

  std::string nodes_;
  std::vector<std::pair<std::string, std::string>> categories_;
};

std::string selects(std::initializer_list<const char*> features) {
  std::string text;
  for (const char* feature : features) text += fmt::format("<pSelected>{}</pSelected>", feature);
  return text;
}

void add_device(Features& features) {
  features.begin_category("DeviceControl");
  features.choice("DeviceType", "Transmitter");
  features.choice("DeviceScanType", "Areascan3D");
  features.text("DeviceVendorName", 0x48, 32);
  features.text("DeviceModelName", 0x68, 32);
  features.text("DeviceVersion", 0x88, 32);
  features.text("DeviceSerialNumber", 0xd8, 16);
  features.constant("DeviceSFNCVersionMajor", 2);
  features.constant("DeviceSFNCVersionMinor", 7);
  features.constant("DeviceSFNCVersionSubMinor", 0);
}

void add_pictures(Features& features) {
  using enum GigeRegister;
  features.begin_category("ImageFormatControl");
  for (const auto& [name, where] :
       {std::pair{"SensorWidth", sensor_width}, std::pair{"SensorHeight", sensor_height},
        std::pair{"WidthMax", sensor_width}, std::pair{"HeightMax", sensor_height}}) {
    features.integer(name, where, "RO");
  }
  features.integer("Width", width, "RW", "<Min>1</Min><pMax>WidthMaxKept</pMax><Inc>1</Inc>");
  features.integer("Height", height, "RW", "<Min>1</Min><pMax>HeightMaxKept</pMax><Inc>1</Inc>");
  for (const auto& [name, whole, taken, where] :
       {std::tuple{"OffsetX", "WidthMax", "Width", left},
        std::tuple{"OffsetY", "HeightMax", "Height", top}}) {
    features.integer(name, where, "RW", fmt::format("<Min>0</Min><pMax>{}Most</pMax>", name));
    features.node("IntSwissKnife", fmt::format("{}Most", name),
                  fmt::format("<pVariable Name=\"A\">{}Kept</pVariable><pVariable Name=\"B\">{}Kept"
                              "</pVariable><Formula>A-B</Formula>",
                              whole, taken));
  }
  features.choice("ComponentSelector", {{"Range", 0}, {"Intensity", 1}, {"Confidence", 2}},
                  at(Scan3dRegister::component_selector), "RW", "",
                  selects({"ComponentEnable", "ComponentIDValue", "PixelFormat"}));
  features.add("Boolean", "ComponentEnable", "<pValue>ComponentEnableKept</pValue>");
  features.keep("IntReg", "ComponentEnable",
                static_cast<std::uint32_t>(Scan3dRegister::component_enable), "RW",
                "ComponentSelector");
  features.integer("ComponentIDValue", at(Scan3dRegister::component_id), "RO", "",
                   "ComponentSelector");
  const auto format = [](const char* name, GigePixels pixels, int component) {
    return Entry{name, static_cast<std::uint32_t>(pixels),
                 fmt::format("<pIsAvailable>IsComponent{}</pIsAvailable>", component)};
  };
  features.choice(
      "PixelFormat",
      {format("Coord3D_ABC32f", GigePixels::coord3d_abc32f, 0),
       format("Coord3D_C32f", GigePixels::coord3d_c32f, 0),
       format("Coord3D_C16", GigePixels::coord3d_c16, 0), format("Mono8", GigePixels::mono8, 1),
       format("Confidence8", GigePixels::confidence8, 2)},
      at(Scan3dRegister::pixel_format), "RW", "ComponentSelector");
  for (int component = 0; component < 3; ++component) {
    features.node("IntSwissKnife", fmt::format("IsComponent{}", component),
                  fmt::format("<pVariable Name=\"A\">ComponentSelectorKept</pVariable>"
                              "<Formula>A={}</Formula>",
                              component));
  }
}

void add_acquisition(Features& features) {
  using enum GigeRegister;
  features.begin_category("AcquisitionControl");
  features.choice("AcquisitionMode", {{"Continuous", 1}, {"SingleFrame", 2}},
                  at(Scan3dRegister::acquisition_mode), "RW");
  features.command("AcquisitionStart", "Acquisition", 1);
  features.command("AcquisitionStop", "Acquisition", 0);
  features.keep("IntReg", "Acquisition", static_cast<std::uint32_t>(acquisition), "RW");
  features.add("Float", "AcquisitionFrameRate",
               "<pValue>FrameRate</pValue><Min>0.1</Min><Max>1000</Max><Unit>Hz</Unit>");
  features.node("Converter", "FrameRate",
                "<FormulaTo>1000000/FROM</FormulaTo><FormulaFrom>1000000/TO</FormulaFrom>"
                "<pValue>FramePeriodKept</pValue><Slope>Decreasing</Slope>");
  features.keep("IntReg", "FramePeriod", static_cast<std::uint32_t>(frame_period), "RW");
  features.choice("TriggerSelector", "FrameStart");
  features.choice("TriggerMode", {{"Off", 0}, {"On", 1}}, trigger_mode, "RW");
  features.choice("TriggerSource", {{"Software", 1}}, trigger_source, "RW");
  features.command("TriggerSoftware", "SoftwareTrigger", 1);
  features.keep("IntReg", "SoftwareTrigger", static_cast<std::uint32_t>(software_trigger), "RW");
}

void add_scan3d(Features& features) {
  features.begin_category("Scan3dControl");
  features.choice("Scan3dDistanceUnit", "Millimeter");
  features.choice("Scan3dCoordinateSystem", "Cartesian");
  features.choice("Scan3dCoordinateSystemReference", "Anchor");
  features.choice("Scan3dOutputMode",
                  {{"CalibratedABC_Grid", calibrated_abc_grid}, {"ProjectedC", projected_c}},
                  at(Scan3dRegister::output_mode), "RW");
  features.number("Scan3dFocalLength", at(Scan3dRegister::focal_length), "RO");
  features.number("Scan3dPrincipalPointU", at(Scan3dRegister::principal_u), "RO");
  features.number("Scan3dPrincipalPointV", at(Scan3dRegister::principal_v), "RO");
  const std::string coordinate = "Scan3dCoordinateSelector";
  features.choice(coordinate, {{"CoordinateA", 0}, {"CoordinateB", 1}, {"CoordinateC", 2}},
                  at(Scan3dRegister::coordinate_selector), "RW", "",
                  selects({"Scan3dCoordinateScale", "Scan3dCoordinateOffset",
                           "Scan3dInvalidDataFlag", "Scan3dInvalidDataValue"}));
  features.number("Scan3dCoordinateScale", at(Scan3dRegister::coordinate_scale), "RW", coordinate);
  features.number("Scan3dCoordinateOffset", at(Scan3dRegister::coordinate_offset), "RW",
                  coordinate);
  features.add("Boolean", "Scan3dInvalidDataFlag", "<pValue>Scan3dInvalidDataFlagKept</pValue>");
  features.keep("IntReg", "Scan3dInvalidDataFlag",
                static_cast<std::uint32_t>(Scan3dRegister::invalid_flag), "RO", coordinate);
  features.number("Scan3dInvalidDataValue", at(Scan3dRegister::invalid_value), "RO", coordinate);
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/// A name as GenApi wants them: "MinModulation" of "min-modulation".
std::string name_from(const std::string& words) {
  std::string name;
  bool begins = true;
  for (const char c : words) {
    const bool is_part = is_letter(c) || (c >= '0' && c <= '9');
    if (is_part) name += begins && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    begins = !is_part;
    if (begins && !name.empty() && name.back() != '_' && c != '-') name += '_';
  }
  return !name.empty() && is_letter(name.front()) ? name : "N" + name;
}

std::string escaped(const std::string& words) {
  std::string text;
  for (const char c : words) text += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return text;
}

/// Settings that SFNC has a name for, and one that would be taken for another.
std::string feature_name(const RunSetting& setting) {
  return setting.name == "exposure" ? "ExposureTime"
         : setting.name == "rate"   ? "CameraFrameRate"
                                    : name_from(setting.name);
}

void add_setting(Features& features, const RunSetting& setting, GigeRegister where) {
  const auto& [name, help, unit, value, choices, least, most, state] = setting;
  const std::string shown = feature_name(setting);
  const std::string words = "<ToolTip>" + escaped(help) + "</ToolTip>";
  const std::string kept = "<pValue>" + shown + "Kept</pValue>";
  const bool is_switch = choices == std::vector<std::string>{"off", "on"};
  if (choices.empty()) {
    const double scale = feature_scale(setting);
    features.add("Float", shown,
                 fmt::format("{}{}<Min>{:.6g}</Min><Max>{:.6g}</Max><Unit>{}</Unit>", words, kept,
                             least * scale, most * scale,
                             scale != 1      ? "us"
                             : !unit.empty() ? escaped(unit)
                                             : "1"));
  } else if (is_switch) {
    features.add("Boolean", shown, words + kept);
  } else {
    std::string entries;
    for (std::size_t i = 0; i < choices.size(); ++i) {
      entries += fmt::format(
          "<EnumEntry Name=\"{}\"><DisplayName>{}</DisplayName><Value>{}</Value></EnumEntry>",
          name_from(choices[i]), escaped(choices[i]), i);
    }
    features.add("Enumeration", shown, words + entries + kept);
  }
  features.keep(choices.empty() ? "FloatReg" : "IntReg", shown, static_cast<std::uint32_t>(where),
                "RW");
}

void add_transport(Features& features) {
  using enum GigeRegister;
  features.begin_category("TransportLayerControl");
  features.integer("PayloadSize", at(Scan3dRegister::payload_size), "RO");
  features.constant("TLParamsLocked", 0);
  features.integer("GevHeartbeatTimeout", heartbeat_timeout, "RW");
  features.integer("GevSCPD", packet_delay, "RW");
  const auto part = [&](const std::string& name, const std::string& bits) {
    features.node("MaskedIntReg", name + "Kept",
                  fmt::format("<Address>0x{:X}</Address><Length>4</Length><AccessMode>RW"
                              "</AccessMode><pPort>Device</pPort><Cachable>NoCache</Cachable>{}"
                              "<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>",
                              static_cast<std::uint32_t>(packet_size), bits));
  };
  features.add("Integer", "GevSCPSPacketSize",
               fmt::format("<pValue>GevSCPSPacketSizeKept</pValue><Min>{}</Min><Max>{}</Max>"
                           "<Inc>4</Inc>",
                           smallest_gige_packet, largest_gige_packet));
  part("GevSCPSPacketSize", "<LSB>31</LSB><MSB>16</MSB>");
  features.command("GevSCPSFireTestPacket", "GevSCPSFireTestPacket", 1);
  part("GevSCPSFireTestPacket", "<Bit>0</Bit>");
}

}  // namespace

double feature_scale(const RunSetting& setting) {
  return setting.name == "exposure" ? 1000 : 1;
}

std::string scan3d_description(const std::vector<RunSetting>& settings) {
  Features features;
  add_device(features);
  add_pictures(features);
  add_acquisition(features);
  add_scan3d(features);
  features.begin_category("ScannerControl");
  for (std::uint32_t i = 0; i < settings.size(); ++i) {
    add_setting(features, settings[i], at(Scan3dRegister::setting, i));
  }
  add_transport(features);
  return fmt::format(
      R"(<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription ModelName="Scanner" VendorName="slipstream" StandardNameSpace="GEV"
 SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0"
 ProductGuid="6f1c2a52-6a05-4f6e-9a4e-3d0c5f1f7b10" VersionGuid="0b7e0c0e-7f0d-4a5b-8d5e-52a1f0c6a9d3"
 xmlns="http://www.genicam.org/GenApi/Version_1_1"
 xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
 xsi:schemaLocation="http://www.genicam.org/GenApi/Version_1_1 http://www.genicam.org/GenApi/GenApiSchema_Version_1_1.xsd">
{}<Port Name="Device"/>
</RegisterDescription>
)",
      features.text());
}

}  // namespace slipstream
