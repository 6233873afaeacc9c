#include "reconstruct/table_engine.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <type_traits>
#include <vector>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/fused/fused_engine.h"
#include "reconstruct/lens_table.h"
#include "reconstruct/points.h"

namespace slipstream {
namespace {

/// The coefficients of the third form, (2.29)-(2.31), at each pixel. F_x and F_y are 0, as points
/// are in the camera's frame.
struct FormTable {
  Image<float> M_z, N_z, C, E_x, E_y;
};

/// A row of a projection matrix.
using Weights = Eigen::Matrix<float, 1, 4>;

/// Modulation and phase that belong to U and V, side by side: one place in memory for both.
struct LookedUp {
  float modulation;  ///< MLUT: (2.4), (2.7), (2.10)
  float phase;       ///< PLUT: (2.16)-(2.18)
};

FormTable form_table(const Lens& camera, const ProjectionMatrices& matrices) {
  const Image<PointForm3> exact = point_table(undistorted_pixels(camera), matrices, point_form3);

  // One coefficient of all pixels, in float.
  const auto part = [&](double PointForm3::*coefficient) {
    Image<float> plane(exact.size());
    std::ranges::transform(exact, plane.begin(), [&](const PointForm3& form) {
      return static_cast<float>(form.*coefficient);
    });
    return plane;
  };

  return {.M_z = part(&PointForm3::M_z),
          .N_z = part(&PointForm3::N_z),
          .C = part(&PointForm3::C),
          .E_x = part(&PointForm3::E_x),
          .E_y = part(&PointForm3::E_y)};
}

/// MLUT and PLUT, from the least U of the least V on.
std::vector<LookedUp> looked_up(const PhaseTables& tables) {
  std::vector<LookedUp> both;
  for (int V = -tables.largest_V(); V <= tables.largest_V(); ++V) {
    for (int U = -tables.largest_U(); U <= tables.largest_U(); ++U) {
      both.push_back(
          {static_cast<float>(tables.mlut(U, V)), static_cast<float>(tables.plut(U, V))});
    }
  }
  return both;
}

}  // namespace

/// Pixels of a row that go through the stages together.
struct TableEngine::Block {
  static constexpr int pixels = 4 * LensSegment::pixels;

  std::array<int, pixels> entry;  ///< in the table of modulation and phase
  std::array<float, pixels> mean, modulation, phase, y;
  std::array<int, pixels> greatest;

  std::array<float, pixels> X, Y, Z;
  std::array<int, pixels>
      is_sure;  ///< 1: the point is valid for certain; others need `validity_of`

  std::array<Validity, pixels> validity;
};

struct TableEngine::Tables {
  Tables(const EngineSetup& of, const StepRun& run, const PhaseCorrection* correction)
      : setup(of),
        phases(run.steps, correction),
        entries(looked_up(phases)),
        triangulate(of.scanner, of.sequence.axis, PointMethod::form3),
        depths(depth_range(of)),
        least_coordinate(-0.5 / projector_length(of)) {
    const Lens& projector = of.scanner.projector;
    const ProjectionMatrices matrices = projection_matrices(of.scanner, of.sequence.axis);
    forms = form_table(of.scanner.camera, matrices);
    if (!is_straight(projector)) lens = lens_table(triangulate, matrices, depths);

    // Inside this margin of the field, a lens that shifts by less cannot put a point outside it.
    const Axis other = across(of.sequence.axis);
    const double length = length_along(other, projector.size);
    safe_margin = static_cast<float>(of.settings.field_margin -
                                     2 * largest_shift(projector, other) - 1 / length);

    across_coordinate = projection_matrices(of.scanner, other).projector_coordinate.cast<float>();
    projector_depth = matrices.projector_depth.cast<float>();

    // A little inside the range, so that rounding to float cannot put a depth beyond its ends.
    constexpr double rounding = 1e-5;
    nearest = static_cast<float>(depths.nearest * (1 + rounding));
    farthest = static_cast<float>(depths.farthest * (1 - rounding));
  }

  [[nodiscard]] Size size() const { return forms.C.size(); }

  template <int N>
  void find_phases(const std::array<const std::uint8_t*, N>& rows, int count, Block& block) const;
  void find_points(int column, int row, int count, Block& block) const;

  /// Whether the points of the tables are the reference's, to a hundred-thousandth of their depth:
  /// compared over the picture and the field, wherever the tables' are used.
  [[nodiscard]] bool is_exact() const {
    constexpr int pixels = 16, coordinates = 24;
    Block block{};

    for (int i = 0; i < pixels * pixels * coordinates; ++i) {
      const int column = (i % pixels) * (size().width - 1) / (pixels - 1);
      const int row = (i / pixels % pixels) * (size().height - 1) / (pixels - 1);
      const double y = (i / (pixels * pixels) + 0.5) / coordinates;

      // A block must begin with a lens segment.
      const int first = column / LensSegment::pixels * LensSegment::pixels, at = column - first;
      block.y.fill(static_cast<float>(y));
      find_points(first, row, at + 1, block);
      if (block.is_sure[at] == 0) continue;

      const Eigen::Vector3d exact = triangulate(column, row, y);
      const Eigen::Vector3d by_tables(block.X[at], block.Y[at], block.Z[at]);
      if (!((by_tables - exact).norm() < 1e-5 * exact.z())) return false;
    }

    return true;
  }

  EngineSetup setup;
  PhaseTables phases;
  std::vector<LookedUp> entries;

  Triangulator triangulate;
  FormTable forms;
  Image<LensSegment> lens;  ///< empty without distortion

  DepthRange depths;
  double least_coordinate;  ///< left edge of the field's first pixel
  float safe_margin = 0, nearest = 0, farthest = 0;
  Weights across_coordinate, projector_depth;
};

/// The first two stages: intensities to modulation and phase.
template <int N>
void TableEngine::Tables::find_phases(const std::array<const std::uint8_t*, N>& rows, int count,
                                      Block& block) const {
  const ClosedForm form = phases.form();
  const int stride = 2 * phases.largest_U() + 1;
  const LookedUp* const at_zero = &entries[entries.size() / 2];
  const auto end = static_cast<float>(1 + least_coordinate);
  constexpr auto turn = static_cast<float>(1 / two_pi);

  for (int i = 0; i < count; ++i) {
    // U and V, sums of intensities, are the place in the table, counted from U = V = 0.
    std::array<int, N> I;
    for (int n = 0; n < N; ++n) I[n] = rows[n][i];
    const auto [U, V] = table_index<int>(form, std::span<const int>(I));
    block.entry[i] = V * stride + U;

    block.mean[i] = static_cast<float>(std::accumulate(I.begin(), I.end(), 0)) / float{N};
    block.greatest[i] = *std::ranges::max_element(I);
  }

  // Look-ups apart from the sums, so that several wait for memory at once.
  for (int i = 0; i < count; ++i) {
    const LookedUp entry = at_zero[block.entry[i]];
    block.modulation[i] = entry.modulation;
    block.phase[i] = entry.phase;
  }

  // The coordinate of one period across the field.
  for (int i = 0; i < count; ++i) {
    const float y = block.phase[i] * turn;
    block.y[i] = y - static_cast<float>(y >= end);
  }
}

/// The third stage: coordinates to points by the third form, after the projector's lens. `column`
/// is the first of a segment.
void TableEngine::Tables::find_points(int column, int row, int count, Block& block) const {
  // Results go into arrays of their own, which the compiler knows to be apart from the tables: it
  // vectorises.
  std::array<float, Block::pixels> X, Y, Z, y = block.y;
  std::array<int, Block::pixels> is_sure;
  is_sure.fill(1);

  // 1. Undistorted coordinates.
  for (int first = 0; first < count && !lens.empty(); first += LensSegment::pixels) {
    const auto& [middle, scale, c] = lens((column + first) / LensSegment::pixels, row);
    for (int i = 0; i < LensSegment::pixels; ++i) {
      const auto t = static_cast<float>(i);
      const float u = (y[first + i] - middle) * scale;
      float shift = c[lens_terms - 1][0] + t * (c[lens_terms - 1][1] + t * c[lens_terms - 1][2]);
      for (int k = lens_terms - 2; k >= 0; --k) {
        shift = shift * u + c[k][0] + t * (c[k][1] + t * c[k][2]);
      }
      y[first + i] += shift;
      is_sure[first + i] = std::abs(u) <= 1;
    }
  }

  // 2. Points.
  const auto from = [&](const Image<float>& plane) { return plane.row(row) + column; };
  const float *const M_z = from(forms.M_z), *const N_z = from(forms.N_z), *const C = from(forms.C);
  const float *const E_x = from(forms.E_x), *const E_y = from(forms.E_y);
  constexpr float least_divisor = 0.03F;  // of a smaller one, floats hold too few digits
  for (int i = 0; i < count; ++i) {
    const float divisor = C[i] * y[i] + 1;  // 0 at infinity
    Z[i] = M_z[i] + N_z[i] / divisor;       // (2.29)
    X[i] = E_x[i] * Z[i];                   // (2.30)
    Y[i] = E_y[i] * Z[i];                   // (2.31)
    is_sure[i] &= (std::abs(divisor) > least_divisor) & (Z[i] > 0);
  }

  // 3. Whether they are in range. The place across the axis is a ratio, place / depth; multiplied
  // out, it needs no division.
  const Weights depth_of = projector_depth, place_of = across_coordinate;
  const float margin = safe_margin, least_z = nearest, most_z = farthest;
  const auto along = [&](const Weights& weights, int i) {
    return weights[0] * X[i] + weights[1] * Y[i] + weights[2] * Z[i] + weights[3];
  };
  for (int i = 0; i < count; ++i) {
    const float depth = along(depth_of, i), place = along(place_of, i);
    is_sure[i] &= (Z[i] >= least_z) & (Z[i] <= most_z) & (depth > 0) & (place >= -margin * depth) &
                  (place <= (1 + margin) * depth);
  }

  block.X = X;
  block.Y = Y;
  block.Z = Z;
  block.is_sure = is_sure;
}

std::optional<TableEngine> TableEngine::make(const EngineSetup& setup,
                                             const PhaseCorrections& corrections,
                                             std::string* why_not) {
  const auto refuse = [&](const char* why) {
    *why_not = why;
    return std::nullopt;
  };

  if (setup.settings.phase_method != PhaseMethod::tables) return refuse("phases by other methods");
  if (unwraps_by_picture(setup)) return refuse("fringe orders come from the whole picture");

  const Layout& layout = setup.sequence.strategy.layout();
  const std::optional<StepRun> run = step_run(layout.bands.front());
  const bool has_tables = run && (run->steps == 3 || run->steps == 4 || run->steps == 6);

  const bool is_plain = layout.bands.size() == 1 && !layout.cue && !layout.code &&
                        layout.single_frames.empty() && layout.unwrapping == Unwrapping::none &&
                        layout.bands.front().periods == 1 && layout.bands.front().carrier == 0;

  if (layout.bands.front().cycle) return refuse("extra frames for motion");
  if (!has_tables || !is_plain || run->first != 0 || run->steps != layout.frames) {
    return refuse("patterns other than 3, 4 or 6 steps of one period");
  }
  if (run->shifts != Shifts{}) return refuse("phases that run backwards or do not begin at 0");

  const auto correction = corrections.find(run->steps);
  auto tables = std::make_shared<Tables>(
      setup, *run, correction == corrections.end() ? nullptr : &correction->second);

  if (!tables->is_exact()) {
    return refuse("its polynomials do not describe this projector lens exactly enough");
  }
  return TableEngine(std::move(tables));
}

bool TableEngine::takes(const FrameViews& frames) {
  const bool has_bytes = frames.visit(
      []<class Pixel>(const Frames<Pixel>&) { return std::is_same_v<Pixel, std::uint8_t>; });
  return has_bytes && !frames.merged();
}

void TableEngine::operator()(const FrameViews& frames, const Outputs& outputs) const {
  const Tables& tables = *tables_;
  require_size(frames, tables.setup.scanner.camera.size);
  throw_if(frames.count() != tables.setup.sequence.strategy.layout().frames,
           "{} frames given; expected {}", frames.count(),
           tables.setup.sequence.strategy.layout().frames);

  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_same_v<Pixel, std::uint8_t>) {
      if (views.size() == 3) return run<3>(views, outputs);
      if (views.size() == 4) return run<4>(views, outputs);
      return run<6>(views, outputs);
    }
  });
}

void TableEngine::write_phases(const Block& block, int column, int row, int count,
                               const Outputs& outputs) {
  const auto write = [&](const std::array<float, Block::pixels>& from, Image<float>& to) {
    std::copy_n(from.begin(), count, to.row(row) + column);
  };

  if (outputs.modulation != nullptr) write(block.modulation, *outputs.modulation);
  if (Maps* const maps = outputs.maps) {
    write(block.mean, maps->mean);
    write(block.modulation, maps->modulation);
    write(block.phase, maps->wrapped_phase);
    write(block.y, maps->coordinate);
  }
}

void TableEngine::write_points(const Block& block, int column, int row, int count,
                               const Outputs& outputs) {
  const auto write = [&](const auto& from, auto& to) {
    std::copy_n(from.begin(), count, to.row(row) + column);
  };

  if (Cloud* const cloud = outputs.cloud) {
    write(block.X, cloud->x);
    write(block.Y, cloud->y);
    write(block.Z, cloud->z);
    write(block.mean, cloud->intensity);
    write(block.validity, cloud->validity);
  }

  if (Depth* const depth = outputs.depth) {
    write(block.Z, depth->z);
    write(block.validity, depth->validity);
  }

  if (outputs.depth16 != nullptr) {
    std::transform(block.Z.begin(), block.Z.begin() + count, outputs.depth16->row(row) + column,
                   outputs.scale);
  }
}

/// Points that the tables do not give for certain are found as by the reference.
void TableEngine::judge(int column, int row, int count, Block& block) const {
  const EngineSetup& setup = tables_->setup;
  const auto least = static_cast<float>(least_modulation(setup.settings, 255));
  const int saturation = setup.settings.drop_saturated ? 255 : 256;

  for (int i = 0; i < count; ++i) {
    Validity& validity = block.validity[i];
    validity = block.modulation[i] < least       ? Validity::too_dark
               : block.greatest[i] >= saturation ? Validity::saturated
                                                 : Validity::valid;

    if (validity == Validity::valid && block.is_sure[i] == 0) {
      const Eigen::Vector3d point = tables_->triangulate(column + i, row, block.y[i]);
      validity = validity_of(block.y[i], point, setup);
      block.X[i] = static_cast<float>(point.x());
      block.Y[i] = static_cast<float>(point.y());
      block.Z[i] = static_cast<float>(point.z());
    }

    if (validity != Validity::valid) {
      block.X[i] = block.Y[i] = block.Z[i] = std::numeric_limits<float>::quiet_NaN();
    }
  }
}

template <int N>
void TableEngine::run(const Frames<std::uint8_t>& frames, const Outputs& outputs) const {
  const Tables& tables = *tables_;
  const Size size = tables.size();
  prepare(outputs, size, false);

  for_each_row(size.height, [&](int row) {
    Block block{};
    for (int column = 0; column < size.width; column += Block::pixels) {
      const int count = std::min(Block::pixels, size.width - column);
      std::array<const std::uint8_t*, N> rows;
      for (int n = 0; n < N; ++n) rows[n] = frames[n].row(row) + column;

      tables.find_phases<N>(rows, count, block);
      write_phases(block, column, row, count, outputs);
      if (!outputs.makes_points()) continue;

      tables.find_points(column, row, count, block);
      judge(column, row, count, block);
      write_points(block, column, row, count, outputs);
    }
  });
}

}  // namespace slipstream
