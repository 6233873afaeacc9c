#pragma once

namespace slipstream {

/// How the intensity is declared in PLY. MeshLab takes an intensity of 32-bit float for a grey of 0
/// to 1 and paints the points white with it, over their red, green and blue; of a double it knows
/// nothing.
inline constexpr const char* ply_intensity = "property double intensity\n";

}  // namespace slipstream
