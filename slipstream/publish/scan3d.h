#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/devices/gige_block.h"
#include "slipstream/publish/cloud_sink.h"

namespace slipstream {

/// Registers of a 3-D camera beside those of every camera, 32 bits each. Of those from
/// component_enable on there is one for each component: range, intensity, confidence; or
/// coordinate: X, Y, Z.
namespace scan3d {
inline constexpr GigeRegister component_selector{0x8000};
inline constexpr GigeRegister coordinate_selector{0x8004};
inline constexpr GigeRegister acquisition_mode{0x8008};  ///< 1: goes on; 2: one cloud
inline constexpr GigeRegister output_mode{0x800c};
inline constexpr GigeRegister payload_size{0x8010};
inline constexpr GigeRegister focal_length{0x8014};  ///< float, as the two that follow
inline constexpr GigeRegister principal_u{0x8018};
inline constexpr GigeRegister principal_v{0x801c};
inline constexpr GigeRegister component_enable{0x8020};
inline constexpr GigeRegister component_id{0x8030};
inline constexpr GigeRegister pixel_format{0x8040};
inline constexpr GigeRegister coordinate_scale{0x8050};  ///< float, as the two that follow
inline constexpr GigeRegister coordinate_offset{0x8060};
inline constexpr GigeRegister invalid_value{0x8070};
inline constexpr GigeRegister invalid_flag{0x8080};
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

/// What the camera at that address says before anybody asks: its registers and behind them, as
/// GenApi describes it, what it can do: the features of the SFNC's Scan3d cameras, and what can be
/// changed of the run. `port`: from which it streams.
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
