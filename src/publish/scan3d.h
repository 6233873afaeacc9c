#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "devices/gige_protocol.h"
#include "slipstream/cloud_sink.h"

namespace slipstream {

/// Additional 32-bit registers of a 3-D camera. From component_enable on there is one per component
/// (range, intensity, confidence) or coordinate (X, Y, Z).
namespace scan3d {
inline constexpr GigeRegister component_selector{0x8000}, coordinate_selector{0x8004};
inline constexpr GigeRegister acquisition_mode{0x8008};  ///< 1: continuous; 2: one cloud
inline constexpr GigeRegister output_mode{0x800c}, payload_size{0x8010};
/// Floats.
inline constexpr GigeRegister focal_length{0x8014}, principal_u{0x8018}, principal_v{0x801c};
inline constexpr GigeRegister component_enable{0x8020}, component_id{0x8030}, pixel_format{0x8040};
/// Floats, except the flag.
inline constexpr GigeRegister coordinate_scale{0x8050}, coordinate_offset{0x8060};
inline constexpr GigeRegister invalid_value{0x8070}, invalid_flag{0x8080};
/// With a frame other than the camera's: six floats, the three angles and the translation from the
/// anchor, and its name.
inline constexpr GigeRegister reference_selector{0x8090}, reference_value{0x80a0};
inline constexpr std::uint32_t frame_text = 0x80c0, frame_text_bytes = 64;
/// The run's settings, in order: a float, or the index of a choice.
inline constexpr GigeRegister setting{0x8100};

enum OutputMode : std::uint32_t { calibrated_abc_grid = 2, projected_c = 13 };
}  // namespace scan3d

constexpr GigeRegister at(GigeRegister first, std::uint32_t index) {
  return static_cast<GigeRegister>(static_cast<std::uint32_t>(first) + 4 * index);
}

/// A float's bits as stored in a register.
inline std::uint32_t bits_of(double number) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(number));
}

inline constexpr std::array scan3d_components{GigeComponent::range, GigeComponent::intensity,
                                              GigeComponent::confidence};
inline constexpr std::uint32_t smallest_gige_packet = 576, largest_gige_packet = 65500;
inline constexpr std::uint32_t gige_multipart = 0x40;  ///< bit in stream_configuration

/// Factor from a setting's unit to its feature's: 1000 us are 1 ms.
double feature_scale(const RunSetting& setting);

/// The value that a setting's register stands for: the bits of a float, or the index of a choice.
/// nullopt if there is no such choice.
std::optional<std::string> value_in_register(const RunSetting& setting, std::uint32_t bits);

/// The registers of the camera at that address, followed by its GenApi description: the SFNC's
/// Scan3d features and the run's settings. `port`: source port of the stream.
std::vector<std::uint8_t> scan3d_memory(const std::string& address, const PublishedRun& run,
                                        const std::vector<RunSetting>& settings,
                                        std::uint16_t port);

/// Addresses of the registers that a client may write at all.
GigeControl::Writable scan3d_writable();

/// How to build the stream from a cloud.
struct Packing {
  std::vector<std::pair<GigeComponent, GigePixels>> parts;
  DepthScale depth{};  ///< 16-bit
  bool is_multipart = false;
};

/// One picture of a region of the cloud, in the given pixel format.
void write_part(const Cloud& cloud, const Rectangle& region, const Packing& packing,
                GigePart& part);

}  // namespace slipstream
