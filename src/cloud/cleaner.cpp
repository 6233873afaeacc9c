#include "slipstream/cleaner.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "base/parallel_rows.h"
#include "cloud/depth_planes.h"
#include "cloud/depth_rows.h"
#include "slipstream/error.h"

namespace slipstream {
namespace {

bool is_between(double value, double a, double b) {
  return value >= std::min(a, b) && value <= std::max(a, b);
}

/// Even-odd: whether an odd number of sides lies to the right.
bool is_inside(const std::vector<PictureCorner>& polygon, int column, int row) {
  bool inside = false;

  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PictureCorner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a.row > row) == (b.row > row)) continue;

    const double crossing = a.column + (row - a.row) / (b.row - a.row) * (b.column - a.column);
    if (crossing >= column) inside = !inside;
  }

  return inside;
}

/// 1 for the pixels inside an outline, see CleanSettings.
Image<std::uint8_t> outline_mask(const std::vector<PictureCorner>& outline, Size picture) {
  Image<std::uint8_t> mask(picture);

  for_each_pixel_in_order(picture, [&](int column, int row) {
    const bool inside = outline.size() == 2
                            ? is_between(column, outline[0].column, outline[1].column) &&
                                  is_between(row, outline[0].row, outline[1].row)
                            : is_inside(outline, column, row);
    mask(column, row) = inside ? 1 : 0;
  });

  return mask;
}

/// A row of depths, or NaN, readable one beyond either end.
struct PaddedRow : std::vector<float> {
  void copy(const float* depths, int width) {
    assign(static_cast<std::size_t>(width) + 2, std::numeric_limits<float>::quiet_NaN());
    if (depths != nullptr) std::copy_n(depths, width, data() + 1);
  }
  [[nodiscard]] const float* first() const { return data() + 1; }
};

TrustStage trust_stage(const CleanSettings& settings, const DepthNoise& noise) {
  constexpr float default_share = 0.03F;  ///< of the depth

  TrustStage trust{noise};
  if (settings.largest_sigma) {
    trust.by_depth = noise.noise / static_cast<float>(*settings.largest_sigma);
  } else {
    trust.constant = noise.noise / default_share;
  }

  return trust;
}

}  // namespace

bool PointBox::contains(const Eigen::Vector3d& place) const {
  return is_between(place.x(), least[0], largest[0]) &&
         is_between(place.y(), least[1], largest[1]) && is_between(place.z(), least[2], largest[2]);
}

void require_valid(const CleanSettings& settings) {
  require_in_range(settings);

  for (std::size_t axis = 0; settings.box && axis < 3; ++axis) {
    require_in_range(settings.box->largest[axis] > settings.box->least[axis], "end of the box",
                     settings.box->largest[axis], "more than its start");
  }

  if (settings.box_frame) static_cast<void>(pose_from_frame(*settings.box_frame, camera_frame));
  if (settings.outline.size() == 1) throw Error("an outline requires two corners or more");

  for (const PictureCorner& corner : settings.outline) {
    require_in_range(std::isfinite(corner.column) && std::isfinite(corner.row),
                     "corner of the outline", corner.column + corner.row, "it must be finite");
  }
}

struct Cleaner::Memory {
  std::vector<float> samples;
  PaddedRow first, last, beyond;
  DepthPlanes planes;
  BitPlane mixed, at_edge, thin, outlier, wire, kept;
  std::vector<Word> busy;  ///< of each block, the words with evidence: see find_evidence
  Components components;
  Image<std::uint8_t> outline;  ///< 1 inside
  SurfaceMemory surface;
  std::vector<ValidityCounts> counts;  ///< of each band of rows
};

/// The filtering of one cloud.
struct Cleaner::Pass {
  const CleanSettings& settings;
  Memory& memory;
  Cloud& cloud;
  DepthLimits limits;
  TrustStage trust;
  const Image<float>* modulation;  ///< null: all are trusted
  ValidityCounts counts{};

  static constexpr int rows_together = 64, blocks_together = 8;
  /// Calls `body(i, counts)` for each number below `count`, `together` in one task.
  template <class Body>
  void for_each_counting(int count, int together, const Body& body) {
    const int tasks = (count + together - 1) / together;
    memory.counts.assign(static_cast<std::size_t>(tasks), {});

    const auto run_task = [&](int task) {
      ValidityCounts& counted = memory.counts[static_cast<std::size_t>(task)];
      const int end = std::min(count, (task + 1) * together);
      for (int i = task * together; i < end; ++i) body(i, counted);
    };

    if (tasks == 1) {
      run_task(0);
    } else {
      for_each_row(tasks, [&run_task](int task) { run_task(task); });
    }

    for (const ValidityCounts& counted : memory.counts) {
      for (std::size_t i = 0; i < validity_count; ++i) counts[i] += counted[i];
    }
  }

  /// Calls `visit(row, word)` for the words of a block that have evidence.
  template <class Visit>
  void for_each_busy_word(int block, const Visit& visit) const {
    const int stride = BitPlane::stride_of(cloud.size());
    for_each_bit(memory.busy[static_cast<std::size_t>(block)], block,
                 [&](int place) { visit(place / stride, place % stride); });
  }

  void drop_bits(Word bits, int row, int word, Validity reason, ValidityCounts& counted) const {
    counted[static_cast<std::size_t>(reason)] += static_cast<std::size_t>(std::popcount(bits));

    // Run by run: in large areas a run is a whole word. The sum carries through the lowest run.
    for (; bits != 0; bits &= bits + (bits & -bits)) {
      const int first = std::countr_zero(bits), count = std::countr_one(bits >> first);

      const auto fill = [&](auto& image, auto value) {
        std::fill_n(image.row(row) + word * word_pixels + first, count, value);
      };
      for (Image<float>* axis : {&cloud.x, &cloud.y, &cloud.z}) {
        fill(*axis, std::numeric_limits<float>::quiet_NaN());
      }
      fill(cloud.validity, reason);
    }
  }

  void compare(int row) {
    const int last = cloud.size().height - 1;

    const auto depths = [&](int near) {
      return near < 0 || near > last ? memory.beyond.first() : cloud.z.row(near);
    };

    // The first and last row are copied, since their ends are read beyond the picture's memory.
    DepthPlanes& planes = memory.planes;
    const bool padded = row == 0 || row == last;
    compare_depths(limits, trust,
                   {.width = cloud.size().width,
                    .above = depths(row - 1),
                    .here = !padded    ? cloud.z.row(row)
                            : row == 0 ? memory.first.first()
                                       : memory.last.first(),
                    .below = depths(row + 1),
                    .x = cloud.x.row(row),
                    .y = cloud.y.row(row),
                    .modulation = modulation != nullptr ? modulation->row(row) : nullptr,
                    .point = planes.point.row(row),
                    .trusted = planes.trusted.row(row),
                    .to_right = planes.to_right.row(row),
                    .to_below = planes.to_below.row(row),
                    .bent_along = planes.bent_along.row(row),
                    .bent_across = planes.bent_across.row(row)});
  }

  /// Whether a pixel at an edge between distant surfaces has less modulation than its neighbours:
  /// it sees both, and their fringes partly cancel.
  [[nodiscard]] bool is_dim(int column, int row) const {
    constexpr float far = 0.05F, dim = 0.75F;  // of the depth; of the brightest

    const std::array columns{std::max(column - 1, 0), column,
                             std::min(column + 1, cloud.z.width() - 1)};
    const std::array rows{std::max(row - 1, 0), row, std::min(row + 1, cloud.z.height() - 1)};

    const float z = cloud.z(column, row);
    float nearest = z, farthest = z, brightest = 0;
    for (const int y : rows) {
      for (const int x : columns) {  // no point, NaN, compares false
        nearest = cloud.z(x, y) < nearest ? cloud.z(x, y) : nearest;
        farthest = cloud.z(x, y) > farthest ? cloud.z(x, y) : farthest;
        brightest = std::max(brightest, (*modulation)(x, y));
      }
    }

    return (farthest - z > far * z || z - nearest > far * z) &&
           (*modulation)(column, row) < dim * brightest;
  }

  /// Whether a farther surface begins within the width of a wire in that direction.
  [[nodiscard]] bool ends_before_wall(int column, int row, int right, int down) const {
    constexpr int widest = 4, reach = 7;  // pixels: three, across; mixed ones may be missing
    const float z = cloud.z(column, row), step = limits.step * z;

    // A step back leads to the wall. A step forward does not, nor a surface wider than a wire.
    for (int i = 1; i <= reach; ++i) {
      const float off = cloud.z(column + i * right, row + i * down) - z;
      if (off > step) return true;
      if (off < -step || (i >= widest && off <= step)) return false;
    }

    return false;
  }

  [[nodiscard]] bool is_ridge(int column, int row, int right, int down) const {
    return ends_before_wall(column, row, right, down) &&
           ends_before_wall(column, row, -right, -down);
  }

  /// Pixels of a ridge among the next `most` whose depth goes on straight in that direction, each
  /// beside the one before or diagonally off it.
  [[nodiscard]] int ridge_along(int column, int row, int right, int down, int most) const {
    int ridge = 0;
    float slope = 0, largest = limits.step;

    for (int i = 0; i < most; ++i, largest = limits.bend) {
      const float z = cloud.z(column, row);

      // Go straight on or diagonally, wherever depth continues best.
      const auto off = [&](int aside) {
        const float there = cloud.z(column + right + aside * down, row + down + aside * right);
        return std::isnan(there) ? std::numeric_limits<float>::infinity()
                                 : std::abs(there - z - slope);
      };
      const int aside = std::min({0, -1, 1}, [&](int a, int b) { return off(a) < off(b); });

      if (!(off(aside) <= largest * z)) break;
      column += right + aside * down;
      row += down + aside * right;
      slope = cloud.z(column, row) - z;
      ridge += is_ridge(column, row, down, right) ? 1 : 0;
    }

    return ridge;
  }

  /// Whether a pixel is one of a run that agree along it, at most three wide, before a surface on
  /// both sides. A curtain of mixed pixels has the nearer surface on one of them.
  [[nodiscard]] bool is_wire(int column, int row) const {
    constexpr int shortest = 12, border = 20;  // more than all of them reach

    const Size size = cloud.size();
    if (std::min({column, row, size.width - column - 1, size.height - row - 1}) < border) {
      return false;
    }

    for (const auto& [right, down] : {std::pair{1, 0}, std::pair{0, 1}}) {
      if (is_ridge(column, row, right, down) &&
          ridge_along(column, row, down, right, shortest) +
                  ridge_along(column, row, -down, -right, shortest) >=
              shortest) {
        return !is_dim(column, row);
      }
    }

    return false;
  }

  /// Finds the points to keep. Call before removing points, since it reads depths of other rows.
  void judge(int block) {
    Memory& m = memory;

    // Start from all trusted points, and from the words in which neighbours speak against some.
    const RelationWords relations = m.planes.block(block, cloud.size());
    std::copy_n(relations.trusted, block_words, m.kept.block(block));
    std::fill_n(m.wire.block(block), block_words, Word{0});
    m.busy[static_cast<std::size_t>(block)] =
        find_evidence(relations, {m.mixed.block(block), m.at_edge.block(block), m.thin.block(block),
                                  m.outlier.block(block)});

    for_each_busy_word(block, [&](int row, int w) {
      Word &mixed = m.mixed.row(row)[w], &outlier = m.outlier.row(row)[w];
      Word& wire = m.wire.row(row)[w];

      // The modulation gives further evidence at edges, and saves thin wires.
      if (!settings.drop_mixed) {
        mixed = 0;
      } else if (modulation != nullptr) {  // else nothing tells wires from curtains of mixtures
        for_each_bit(m.at_edge.row(row)[w] & ~mixed, w, [&](int column) {
          mixed |= Word{is_dim(column, row)} << column % word_pixels;
        });
        for_each_bit(m.thin.row(row)[w], w, [&](int column) {
          wire |= Word{is_wire(column, row)} << column % word_pixels;
        });
        mixed &= ~wire;
      }

      // A pixel has one reason at most.
      outlier = settings.drop_outliers ? outlier & ~(mixed | wire) : 0;
      m.kept.row(row)[w] &= ~(mixed | outlier);
    });
  }

  /// Low trust, mixed pixels and outliers.
  void drop(int block, ValidityCounts& counted) const {
    for_each_busy_word(block, [&](int row, int w) {
      const DepthPlanes& planes = memory.planes;
      drop_bits(planes.point.row(row)[w] & ~planes.trusted.row(row)[w], row, w, Validity::low_trust,
                counted);

      drop_bits(memory.mixed.row(row)[w], row, w, Validity::mixed, counted);
      drop_bits(memory.outlier.row(row)[w], row, w, Validity::outlier, counted);
    });
  }

  void drop_small_components() {
    memory.components.find(cloud.size(), memory.planes, memory.kept);

    memory.components.for_each_run_below(settings.smallest_component, [&](const PixelRun& run) {
      const Word* const wire = memory.wire.row(run.row);

      // A wire may be broken into pieces that are small.
      for (int column = run.first; column <= run.last; ++column) {
        if ((wire[column / word_pixels] >> column % word_pixels & 1) != 0) continue;

        cloud.reject(column, run.row, Validity::small_component);
        ++counts[static_cast<std::size_t>(Validity::small_component)];
      }
    });
  }

  void drop_outside() {
    if (!settings.box && settings.outline.empty()) return;

    if (!settings.outline.empty() && memory.outline.size() != cloud.size()) {
      memory.outline = outline_mask(settings.outline, cloud.size());
    }

    Eigen::Isometry3d to_box = Eigen::Isometry3d::Identity();
    if (settings.box_frame) to_box = pose_from_frame(*settings.box_frame, camera_frame).transform;

    for_each_counting(cloud.size().height, rows_together, [&](int row, ValidityCounts& counted) {
      for (int column = 0; column < cloud.size().width; ++column) {
        const bool outlined = settings.outline.empty() || memory.outline(column, row) != 0;
        if (!(cloud.z(column, row) > 0)) continue;
        const bool inside =
            !settings.box || settings.box->contains(to_box * position_at(cloud, column, row));
        if (outlined && inside) continue;

        cloud.reject(column, row, Validity::outside_region);
        ++counted[static_cast<std::size_t>(Validity::outside_region)];
      }
    });
  }

  ValidityCounts run() {
    // 1. Memory, and copies of the first and the last row.
    const Size size = cloud.size();
    memory.planes.prepare(size);
    for (BitPlane* plane : {&memory.mixed, &memory.at_edge, &memory.thin, &memory.outlier,
                            &memory.wire, &memory.kept}) {
      plane->prepare(size);
    }

    const int blocks = BitPlane::blocks_of(size);
    memory.busy.resize(static_cast<std::size_t>(blocks));

    memory.beyond.copy(nullptr, size.width);
    memory.first.copy(cloud.z.row(0), size.width);
    memory.last.copy(cloud.z.row(size.height - 1), size.width);

    // 2. Relations of neighbours, then the points to keep, then remove the others.
    for_each_counting(size.height, rows_together, [&](int row, auto&) { compare(row); });
    for_each_counting(blocks, blocks_together, [&](int block, auto&) { judge(block); });
    for_each_counting(blocks, blocks_together,
                      [&](int block, auto& counted) { drop(block, counted); });

    // 3. Small components and points outside the region.
    if (settings.smallest_component > 1) drop_small_components();
    drop_outside();

    // 4. Fill gaps and smooth.
    if (settings.widest_gap > 0) {
      counts[0] = fill_gaps(cloud, settings.widest_gap, limits, memory.surface);
    }
    if (settings.smoothing > 0) smooth(cloud, settings.smoothing, limits, memory.surface);

    return counts;
  }
};

Cleaner::Cleaner(const CleanSettings& settings)
    : settings_(settings), memory_(std::make_unique<Memory>()) {
  require_valid(settings);
}

Cleaner::~Cleaner() = default;

ValidityCounts Cleaner::operator()(Cloud& cloud, const Image<float>* modulation,
                                   const DepthNoise& noise) {
  if (cloud.z.empty() || settings_ == CleanSettings::none()) return {};
  require_camera_frame(cloud);
  return Pass{.settings = settings_,
              .memory = *memory_,
              .cloud = cloud,
              .limits = depth_limits(cloud, memory_->samples),
              .trust = trust_stage(settings_, noise),
              .modulation = wants_modulation() ? modulation : nullptr}
      .run();
}

}  // namespace slipstream
