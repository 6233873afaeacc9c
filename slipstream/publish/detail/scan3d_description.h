#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "slipstream/devices/gige_control.h"
#include "slipstream/publish/run_setting.h"

namespace slipstream {

/// Registers of a 3-D camera beside those of every camera, 32 bits each. Of the last there is one
/// for each component: range, intensity, confidence; or coordinate: X, Y, Z.
enum class Scan3dRegister : std::uint32_t {
  component_selector = 0x8000,
  coordinate_selector = 0x8004,
  acquisition_mode = 0x8008,  ///< 1: goes on; 2: one cloud
  output_mode = 0x800c,
  payload_size = 0x8010,
  focal_length = 0x8014,  ///< float, as the two that follow
  principal_u = 0x8018,
  principal_v = 0x801c,
  component_enable = 0x8020,
  component_id = 0x8030,
  pixel_format = 0x8040,
  coordinate_scale = 0x8050,  ///< float, as the two that follow
  coordinate_offset = 0x8060,
  invalid_value = 0x8070,
  invalid_flag = 0x8080,
  setting = 0x8100,  ///< of the run, in their order: float, or which of the choices
};

constexpr GigeRegister at(Scan3dRegister which, std::uint32_t index = 0) {
  return static_cast<GigeRegister>(static_cast<std::uint32_t>(which) + 4 * index);
}

enum Scan3dOutputMode : std::uint32_t { calibrated_abc_grid = 2, projected_c = 13 };

inline constexpr std::uint32_t smallest_gige_packet = 576, largest_gige_packet = 65500;

/// How much of a setting's number there is to one of its feature's: 1000 us are 1 ms.
double feature_scale(const RunSetting& setting);

/// What the camera can do and where its registers are, as GenApi describes it: the features of the
/// SFNC's Scan3d cameras, and what can be changed of the run.
std::string scan3d_description(const std::vector<RunSetting>& settings);

}  // namespace slipstream
