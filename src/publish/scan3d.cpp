#include "publish/scan3d.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "base/numbers.h"
#include "base/page.h"
#include "devices/gige_sockets.h"
#include "geometry/rotation.h"
#include "publish/genapi_features.h"

namespace slipstream {
namespace {

std::string formula(const std::string& a, const std::string& b, const std::string& of_both) {
  return fmt::format(
      "<pVariable Name=\"A\">{}Kept</pVariable><pVariable Name=\"B\">{}Kept"
      "</pVariable><Formula>{}</Formula>",
      a, b, of_both);
}

void add_device(Features& features) {
  features.begin_category("DeviceControl");
  features.constant("DeviceType", "Transmitter");
  features.constant("DeviceScanType", "Areascan3D");
  features.text("DeviceVendorName", 0x48, 32);
  features.text("DeviceModelName", 0x68, 32);
  features.text("DeviceVersion", 0x88, 32);
  features.text("DeviceSerialNumber", 0xd8, 16);
}

void add_pictures(Features& features) {
  using enum GigeRegister;
  using namespace scan3d;

  features.begin_category("ImageFormatControl");

  // Sensor and region.
  features.add("Integer", "SensorWidth", sensor_width, "RO");
  features.add("Integer", "SensorHeight", sensor_height, "RO");
  features.add("Integer", "WidthMax", sensor_width, "RO");
  features.add("Integer", "HeightMax", sensor_height, "RO");
  features.add("Integer", "Width", width, "RW", {.after = "<Min>1</Min><pMax>WidthMaxKept</pMax>"});
  features.add("Integer", "Height", height, "RW",
               {.after = "<Min>1</Min><pMax>HeightMaxKept</pMax>"});
  features.add("Integer", "OffsetX", left, "RW", {.after = "<Min>0</Min><pMax>MostX</pMax>"});
  features.add("Integer", "OffsetY", top, "RW", {.after = "<Min>0</Min><pMax>MostY</pMax>"});
  features.node("IntSwissKnife", "MostX", formula("WidthMax", "Width", "A-B"));
  features.node("IntSwissKnife", "MostY", formula("HeightMax", "Height", "A-B"));

  // Components of a cloud, and the pixel format of each.
  const std::string selector = "ComponentSelector";
  features.add("Enumeration", selector, component_selector, "RW",
               {.before = entries({"Range", "Intensity", "Confidence"}),
                .after = selects({"ComponentEnable", "ComponentIDValue", "PixelFormat"})});
  features.add("Boolean", "ComponentEnable", component_enable, "RW", {.selector = selector});
  features.add("Integer", "ComponentIDValue", component_id, "RO", {.selector = selector});

  // Each format belongs to one component (0 range, 1 intensity, 2 confidence); with another one
  // selected it is not available.
  std::string formats;
  for (const auto& [name, pixels, component] :
       {std::tuple{"Coord3D_ABC32f", GigePixels::coord3d_abc32f, 0},
        std::tuple{"Coord3D_C32f", GigePixels::coord3d_c32f, 0},
        std::tuple{"Coord3D_C16", GigePixels::coord3d_c16, 0},
        std::tuple{"Mono8", GigePixels::mono8, 1},
        std::tuple{"Confidence8", GigePixels::confidence8, 2}}) {
    const std::string condition = fmt::format("IsOf{}", name);
    formats += entry(name, static_cast<std::size_t>(pixels),
                     fmt::format("<pIsAvailable>{}</pIsAvailable>", condition));
    features.node("IntSwissKnife", condition,
                  formula(selector, selector, fmt::format("A={}", component)));
  }

  features.add("Enumeration", "PixelFormat", pixel_format, "RW",
               {.before = formats, .selector = selector});
}

void add_acquisition(Features& features) {
  using enum GigeRegister;

  features.begin_category("AcquisitionControl");
  features.add("Enumeration", "AcquisitionMode", scan3d::acquisition_mode, "RW",
               {.before = entries({"Continuous", "SingleFrame"}, 1)});
  features.command("AcquisitionStart", "Acquisition", 1);
  features.command("AcquisitionStop", "Acquisition", 0);
  features.command("TriggerSoftware", "SoftwareTrigger", 1);

  features.constant("TriggerSelector", "FrameStart");
  features.add("Enumeration", "TriggerMode", trigger_mode, "RW",
               {.before = entries({"Off", "On"})});
  features.add("Enumeration", "TriggerSource", trigger_source, "RW",
               {.before = entries({"Software"}, 1)});

  // The rate is shown in Hz, but kept as a period in us.
  features.show("Float", "AcquisitionFrameRate",
                "<pValue>FrameRate</pValue><Min>0.1</Min><Max>1000</Max><Unit>Hz</Unit>");
  features.node("Converter", "FrameRate",
                "<FormulaTo>1000000/FROM</FormulaTo><FormulaFrom>1000000/TO</FormulaFrom>"
                "<pValue>FramePeriodKept</pValue><Slope>Decreasing</Slope>");

  // Registers behind the commands and the rate.
  for (const auto& [name, where] :
       {std::pair{"FramePeriod", frame_period}, std::pair{"Acquisition", acquisition},
        std::pair{"SoftwareTrigger", software_trigger}}) {
    features.keep("IntReg", name, where, "RW", "", unsigned_number);
  }
}

/// Where the points' frame, the anchor, is in another one: P' = Rz Ry Rx P + T.
void add_reference(Features& features) {
  using namespace scan3d;
  const std::string selector = "Scan3dCoordinateReferenceSelector";

  features.add("Enumeration", selector, reference_selector, "RW",
               {.before = entries({"RotationX", "RotationY", "RotationZ", "TranslationX",
                                   "TranslationY", "TranslationZ"}),
                .after = selects({"Scan3dCoordinateReferenceValue"})});
  features.add("Float", "Scan3dCoordinateReferenceValue", reference_value, "RO",
               {.before = "<ToolTip>From the anchor, the camera, to the frame: turn about X, then "
                          "Y, then Z of the frame, degrees, then add the translation, mm</ToolTip>",
                .selector = selector});
  features.text("ScannerFrame", frame_text, frame_text_bytes);
}

void add_scan3d(Features& features, bool has_frame) {
  using namespace scan3d;

  features.begin_category("Scan3dControl");
  features.constant("Scan3dDistanceUnit", "Millimeter");
  features.constant("Scan3dCoordinateSystem", "Cartesian");
  features.constant("Scan3dCoordinateSystemReference", "Anchor");
  features.add("Enumeration", "Scan3dOutputMode", output_mode, "RW",
               {.before = entry("CalibratedABC_Grid", calibrated_abc_grid) +
                          entry("ProjectedC", projected_c)});

  // Pixels, for clients that receive depths alone.
  features.add("Float", "Scan3dFocalLength", focal_length, "RO");
  features.add("Float", "Scan3dPrincipalPointU", principal_u, "RO");
  features.add("Float", "Scan3dPrincipalPointV", principal_v, "RO");

  // Scale, offset and the value of missing points, for each coordinate.
  const std::string selector = "Scan3dCoordinateSelector";
  const Around of_each{.selector = selector};
  features.add("Enumeration", selector, coordinate_selector, "RW",
               {.before = entries({"CoordinateA", "CoordinateB", "CoordinateC"}),
                .after = selects({"Scan3dCoordinateScale", "Scan3dCoordinateOffset",
                                  "Scan3dInvalidDataFlag", "Scan3dInvalidDataValue"})});
  features.add("Float", "Scan3dCoordinateScale", coordinate_scale, "RW", of_each);
  features.add("Float", "Scan3dCoordinateOffset", coordinate_offset, "RW", of_each);
  features.add("Boolean", "Scan3dInvalidDataFlag", invalid_flag, "RO", of_each);
  features.add("Float", "Scan3dInvalidDataValue", invalid_value, "RO", of_each);

  if (has_frame) add_reference(features);
}

/// A GenApi name: "MinimumModulation" from "minimum-modulation".
std::string name_from(const std::string& words) {
  std::string name;
  bool begins = true;
  for (const unsigned char c : words) {
    // Separators end a word: the next letter is a capital. All except "-" leave a "_" behind.
    const bool is_part = std::isalnum(c) != 0;
    if (is_part) name += static_cast<char>(begins ? std::toupper(c) : c);
    begins = !is_part;
    if (begins && !name.empty() && name.back() != '_' && c != '-') name += '_';
  }

  // A name begins with a letter.
  return std::isalpha(static_cast<unsigned char>(name[0])) != 0 ? name : "N" + name;
}

void add_setting(Features& features, const RunSetting& setting, GigeRegister where) {
  const std::string shown = setting.name == "exposure" ? "ExposureTime"     // its SFNC name
                            : setting.name == "rate"   ? "CameraFrameRate"  // its own would clash
                                                       : name_from(setting.name);

  const std::string words = "<ToolTip>" + escaped(setting.help) + "</ToolTip>";

  // A number.
  const auto& choices = setting.choices;
  if (choices.empty()) {
    const double scale = feature_scale(setting);
    return features.add("Float", shown, where, "RW",
                        {.before = words,
                         .after = fmt::format("<Min>{:.6g}</Min><Max>{:.6g}</Max>",
                                              setting.least * scale, setting.most * scale)});
  }

  // A choice, or a switch.
  std::string entries;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    entries +=
        entry(name_from(choices[i]), i, "<DisplayName>" + escaped(choices[i]) + "</DisplayName>");
  }
  const bool is_switch = choices == std::vector<std::string>{"off", "on"};
  features.add(is_switch ? "Boolean" : "Enumeration", shown, where, "RW",
               {.before = words + (is_switch ? "" : entries)});
}

void add_transport(Features& features) {
  using enum GigeRegister;
  features.begin_category("TransportLayerControl");
  features.add("Integer", "PayloadSize", scan3d::payload_size, "RO");
  features.show("Integer", "TLParamsLocked", "<Value>0</Value><Min>0</Min><Max>1</Max>");

  features.add("Integer", "GevHeartbeatTimeout", heartbeat_timeout, "RW");
  features.add("Integer", "GevSCPD", packet_delay, "RW");

  features.part("Integer", "GevSCPSPacketSize", "<LSB>31</LSB><MSB>16</MSB>",
                fmt::format("<Min>{}</Min><Max>{}</Max><Inc>4</Inc>", smallest_gige_packet,
                            largest_gige_packet));
  features.part("Command", "GevSCPSFireTestPacket", "<Bit>0</Bit>",
                "<CommandValue>1</CommandValue>");
}

std::string scan3d_description(const std::vector<RunSetting>& settings, bool has_frame) {
  Features features;
  add_device(features);
  add_pictures(features);
  add_acquisition(features);
  add_scan3d(features, has_frame);

  features.begin_category("ScannerControl");
  for (std::uint32_t i = 0; i < settings.size(); ++i) {
    add_setting(features, settings[i], at(scan3d::setting, i));
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

/// Pixel values of a region, row by row.
template <class ValueAt>
void write_values(std::vector<std::uint8_t>& bytes, const Rectangle& region, ValueAt value_at) {
  using Value = decltype(value_at(0, 0));
  bytes.resize(static_cast<std::size_t>(region.size.width) *
               static_cast<std::size_t>(region.size.height) * sizeof(Value));

  std::uint8_t* to = bytes.data();
  for_each_pixel_in_order(region.size, [&](int column, int row) {
    const Value value = value_at(region.x + column, region.y + row);
    std::memcpy(to, &value, sizeof value);
    to += sizeof value;
  });
}

}  // namespace

double feature_scale(const RunSetting& setting) {
  return setting.name == "exposure" ? 1000 : 1;
}

std::optional<std::string> value_in_register(const RunSetting& setting, std::uint32_t bits) {
  if (setting.choices.empty()) {
    const double number = std::bit_cast<float>(bits);
    return fmt::format("{:.6g}", number / feature_scale(setting));
  }

  if (bits >= setting.choices.size()) return std::nullopt;
  return setting.choices[bits];
}

std::vector<std::uint8_t> scan3d_memory(const std::string& address, const PublishedRun& run,
                                        const std::vector<RunSetting>& settings,
                                        std::uint16_t port) {
  using namespace scan3d;
  using enum GigeRegister;
  constexpr std::array default_pixels{GigePixels::coord3d_abc32f, GigePixels::mono8,
                                      GigePixels::confidence8};

  // 1. The standard's texts, and the description after 64 KiB of registers.
  const std::string description = scan3d_description(settings, run.frame != nullptr);
  std::vector<std::uint8_t> memory(0x10000);

  const auto text = [&](std::size_t at, const std::string& words) {
    std::copy(words.begin(), words.end(), memory.begin() + static_cast<std::ptrdiff_t>(at));
  };
  text(0x48, "slipstream");
  text(0x68, "Scanner");
  text(0x88, "1");
  text(0xd8, address);
  if (run.frame) text(frame_text, run.frame->to);
  text(0x200, fmt::format("Local:slipstream.xml;10000;{:X}", description.size()));
  memory.insert(memory.end(), description.begin(), description.end());
  memory.resize((memory.size() + 3) / 4 * 4);  // clients read four bytes at a time

  // 2. Registers with their values at the start. 16 kB packets fit only the loopback interface.
  GigeControl registers(std::move(memory));
  const std::uint32_t host = ntohl(host_from(address).s_addr);
  const auto wide = static_cast<std::uint32_t>(run.camera.size.width);
  const auto high = static_cast<std::uint32_t>(run.camera.size.height);
  for (const auto& [which, value] : std::initializer_list<std::pair<GigeRegister, std::uint32_t>>{
           {GigeRegister(0x0), 0x00020001},    // version of the standard
           {GigeRegister(0x4), 0x80000001},    // big-endian, UTF-8
           {GigeRegister(0x8), 0x0200},        // a locally administered MAC address,
           {GigeRegister(0xc), host},          // its lower part
           {GigeRegister(0x10), 4},            // supports a link-local address
           {GigeRegister(0x14), 4},            // and uses it
           {GigeRegister(0x24), host},         // its IP address
           {GigeRegister(0x600), 1},           // interfaces
           {GigeRegister(0x904), 1},           // streams
           {GigeRegister(0x934), 0x40000006},  // serial number, memory written, packets sent again
           {GigeRegister(0x940), 1'000'000'000},  // ticks per second
           {GigeRegister(0xd1c), port},
           {GigeRegister(0xd20), gige_multipart},
           {heartbeat_timeout, 3000},
           {packet_size, host >> 24 == 127 ? 16'000 : 1500},
           {trigger_source, 1},
           {frame_period, 33'333},
           {sensor_width, wide},
           {sensor_height, high},
           {width, wide},
           {height, high},
           {acquisition_mode, 1},
           {output_mode, calibrated_abc_grid},
           {component_enable, 1},
           {focal_length, bits_of(run.camera.intrinsic(0, 0))}}) {
    registers.write(which, value);
  }

  // 3. Registers for each component or coordinate.
  for (std::uint32_t i = 0; i < 3; ++i) {
    registers.write(at(component_id, i), static_cast<std::uint32_t>(scan3d_components[i]));
    registers.write(at(pixel_format, i), static_cast<std::uint32_t>(default_pixels[i]));
    registers.write(at(coordinate_scale, i), bits_of(1));
    registers.write(at(invalid_value, i), bits_of(std::numeric_limits<float>::quiet_NaN()));
    registers.write(at(invalid_flag, i), 1);
  }

  // 4. The frame that the points' one is anchored in.
  if (run.frame) {
    const Eigen::Isometry3d& pose = run.frame->transform;
    const Eigen::Vector3d turns =
        euler_of(pose.linear(), {.axes = {0, 1, 2}, .intrinsic = false}) / degree;
    for (std::uint32_t i = 0; i < 3; ++i) {
      registers.write(at(reference_value, i), bits_of(turns[i]));
      registers.write(at(reference_value, 3 + i), bits_of(pose.translation()[i]));
    }
  }

  return registers.memory();
}

GigeControl::Writable scan3d_writable() {
  return {{0x100, 0x108},   {0x124, 0x128},   {0x130, 0x13c},   {0x300, 0x308},   {0x30c, 0x310},
          {0x938, 0x93c},   {0xa00, 0xa04},   {0xd00, 0xd0c},   {0xd18, 0xd1c},   {0xd24, 0xd28},
          {0x8000, 0x8010}, {0x8020, 0x802c}, {0x8040, 0x804c}, {0x8050, 0x805c}, {0x8060, 0x806c},
          {0x8090, 0x8094}, {0x8100, 0x8200}};
}

void write_part(const Cloud& cloud, const Rectangle& region, const Packing& packing,
                GigePart& part) {
  const auto write = [&](auto value_at) { write_values(part.bytes, region, value_at); };

  // Intensity and validity in 8 bits; points as depths in steps, depths in mm, or x, y, z in mm.
  switch (part.pixels) {
    case GigePixels::mono8:
      return write([&](int x, int y) { return grey_level(cloud.intensity(x, y)); });
    case GigePixels::confidence8:
      return write([&](int x, int y) {
        return cloud.validity(x, y) == Validity::valid ? std::uint8_t{255} : std::uint8_t{0};
      });
    case GigePixels::coord3d_c16:
      return write([&](int x, int y) { return packing.depth(cloud.z(x, y)); });
    case GigePixels::coord3d_c32f:
      return write([&](int x, int y) { return cloud.z(x, y); });
    case GigePixels::coord3d_abc32f:
      return write([&](int x, int y) {
        return std::array{cloud.x(x, y), cloud.y(x, y), cloud.z(x, y)};
      });
  }
}

}  // namespace slipstream
