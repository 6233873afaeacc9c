#pragma once

#include <bit>

#include "slipstream/devices/gige_protocol.h"
#include "slipstream/publish/cloud_sink.h"

namespace slipstream {

/// 32-bit registers of a 3-D camera beside those of every camera. From component_enable on there is
/// one for each component (range, intensity, confidence) or coordinate (X, Y, Z).
namespace scan3d {
inline constexpr GigeRegister component_selector{0x8000}, coordinate_selector{0x8004};
inline constexpr GigeRegister acquisition_mode{0x8008};  ///< 1: goes on; 2: one cloud
inline constexpr GigeRegister output_mode{0x800c}, payload_size{0x8010};
/// Floats.
inline constexpr GigeRegister focal_length{0x8014}, principal_u{0x8018}, principal_v{0x801c};
inline constexpr GigeRegister component_enable{0x8020}, component_id{0x8030}, pixel_format{0x8040};
/// Floats, but for the flag.
inline constexpr GigeRegister coordinate_scale{0x8050}, coordinate_offset{0x8060};
inline constexpr GigeRegister invalid_value{0x8070}, invalid_flag{0x8080};
/// Of the run, in their order: float, or which of the choices.
inline constexpr GigeRegister setting{0x8100};

enum OutputMode : std::uint32_t { calibrated_abc_grid = 2, projected_c = 13 };
}  // namespace scan3d

constexpr GigeRegister at(GigeRegister first, std::uint32_t index) {
  return static_cast<GigeRegister>(static_cast<std::uint32_t>(first) + 4 * index);
}

/// A number as a register keeps it that is a float.
inline std::uint32_t bits_of(double number) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(number));
}

inline constexpr std::array scan3d_components{GigeComponent::range, GigeComponent::intensity,
                                              GigeComponent::confidence};
inline constexpr std::uint32_t smallest_gige_packet = 576, largest_gige_packet = 65500;
inline constexpr std::uint32_t gige_multipart = 0x40;  ///< in stream_configuration

/// How much of a setting's number there is to one of its feature's: 1000 us are 1 ms.
double feature_scale(const RunSetting& setting);

/// The registers of the camera at that address, and behind them its description for GenApi: the
/// SFNC's Scan3d features and the run's settings. `port`: from which it streams.
std::vector<std::uint8_t> scan3d_memory(const std::string& address, const PublishedRun& run,
                                        const std::vector<RunSetting>& settings,
                                        std::uint16_t port);

/// How what is sent is made of a cloud.
struct Packing {
  std::vector<std::pair<GigeComponent, GigePixels>> parts;
  DepthScale depth{};  ///< of 16 bits
  bool is_multipart = false;
};

/// One picture of a region of the cloud, as its pixels say.
void write_part(const Cloud& cloud, const Rectangle& region, const Packing& packing,
                GigePart& part);

}  // namespace slipstream
