#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "slipstream/reconstruct/fused/fused_stages.h"
#include "slipstream/reconstruct/fused/sinusoid_rows.h"

namespace slipstream {

/// FusedStages as the shaders read them: stages.glsl, word for word. A place is an index of
/// `words`.
struct GpuStages {
  static constexpr std::size_t most_bands = 16;
  using Word = std::int32_t;
  using Linear = PointStage::Linear;

  /// FieldPlacer's numbers, made of a CoordinateStage: a device's own quotients are not exact.
  struct Coordinate {
    Coordinate() = default;
    explicit Coordinate(const CoordinateStage& stage)
        : scale(stage.scale),
          period(stage.period),
          fields_of_turn(stage.scale / stage.period),
          cut_fields(stage.cut / stage.period) {}
    float scale = 1, period = 1, fields_of_turn = 1, cut_fields = 0;
  };

  /// The sums of a band's frames. Each weight is (a 2^22 + b 2^11 + c) of a unit, so that sums over
  /// `most_frames` frames of 16 bits are exact in integers of 32.
  struct Band {
    static constexpr int most_frames = 31;
    Word first_frame = 0, frames = 0;
    Word weights =
        0;           ///< place of a, b, c of the cosine, of the sine, and the mean's, of each frame
    Word whole = 0;  ///< whether a and b are 0 in all of them
    float cosine_unit = 1, sine_unit = 1;
    float sine_weight = 1, sine_square = 1, modulation_scale = 1;
    float least_square = 0, mean_scale = 1;
    Word full_scale = 0;
    Word steps = 0, wave_terms = 0, wave = 0, segments = 0, table = 0;
    float direction = 1, offset = 0;
    float periods = 1, period = 1, weight = 0;
  };
  /// A sum of bands and how it is unwrapped.
  struct Link {
    Word factors = 0;  ///< place of one for each band
    Word alone = -1;   ///< the band whose sum it is
    float ratio = 1, largest_doubt = 0, open = 0, doubt_scale = 1;
    Coordinate coordinate{};
  };
  /// Places are -1 where there are none.
  struct Code {
    Word bits = 0, frames = -1, inverses = -1, gray = 0, base = 0, others = 0, against_mean = 0;
    Word reference = -1;  ///< place of how many weights there are, and these
    float stripe = 1, mean_to_frames = 1;
  };
  struct Points {
    Linear coordinate{}, depth{}, facing{}, place_constant{}, place_slope{};
    float coordinate_offset = 0, depth_offset = 0, unit_scale = 1, unit_offset = 0;
    float least_coordinate = 0, largest_coordinate = 1;
    Word may_leave_field = 0, lens_degree = 0, lens = 0;
    std::array<float, 6> low_edge{}, high_edge{};
    float inner_low = 0, inner_high = 0, nearest = 0, farthest = 0;
    float half_fringe = 0;
    Word confirmed = 0, fewest_neighbours = 0, fewest_if_doubtful = 0;
  };
  /// Of FusedStages::Cue; its channel is the second band.
  struct Cue {
    Word form = 0;  ///< 0 where there is none, else OrderCostStage::Cue + 1
    float periods = 12, period = 1, gain = 1, offset = 0;
    float shade = 0;  ///< of the mean, by a grey level of 8 bits
    float largest_doubt = 0;
    float share = 1, cue_share = 1;
    float relative_share = 1;  ///< of the cue's, c_2 / c_1
    float constant_light = 0, steady = 0;
    float cue_variance = 1;
    float relative_variance = 1;  ///< of a component, in cue_variance
    float circle_weight = 1;      ///< 1 / ((c_1^2 + c_2^2) component_variance)
    float margin = 0;
    Word lines = 0;  ///< place of SurfaceWindow::line_cells
    float ambient = 0, lit_square = 0, voting_square = 0, to_8_bits = 1;
  };
  /// Where planes of the output begin, in fours of pixels; -1 for those that are not wanted.
  struct Planes {
    Word x = -1, y = -1, z = -1, mean = -1, modulation = -1, phase = -1, coordinate = -1,
         doubt = -1;
  };
  /// What is made of the points.
  struct Packed {
    Word wanted = 0;           ///< points at all
    float numbers_per_mm = 0;  ///< 0: reasons are wanted
    float offset = 0;          ///< mm
  };

  Word width = 0, height = 0;
  Word plane_fours = 0;  ///< of a frame, a plane: fours of pixels
  Word scan_words = 0;   ///< of a scan's frames and coarse coordinates
  Word scan_fours = 0;   ///< of its planes
  Word links = 0;
  Word kept = 2;  ///< words of a pixel between the shaders
  Word begins_with_code = 0;
  Word coarse_given = 0;  ///< words before the coarse coordinates that follow the frames; 0: none
  Word coarse_in_field = 0, weighs_bands = 0;
  Coordinate coarse_stage{}, coordinate{};
  Coordinate weighed{};  ///< of coordinates that are not in turns
  Link coarse{};
  Code code{};
  Points points{};
  Cue cue{};
  Planes planes{};
  Packed packed{};
  std::array<Band, most_bands> bands{};
  std::array<Link, most_bands> chain{};
};

/// Those stages, and the words that they point into.
struct GpuProgramText {
  GpuStages stages;
  std::vector<GpuStages::Word> words;
};

/// None where the shaders cannot stand in: for more bands or frames than they take.
std::optional<GpuProgramText> gpu_stages(const FusedStages& stages);

}  // namespace slipstream
