#include "slipstream/cloud/cleaner.h"

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/cloud/detail/depth_planes.h"

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

bool is_inside(const PointBox& box, const Cloud& cloud, int column, int row) {
  return is_between(cloud.x(column, row), box.least[0], box.largest[0]) &&
         is_between(cloud.y(column, row), box.least[1], box.largest[1]) &&
         is_between(cloud.z(column, row), box.least[2], box.largest[2]);
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

/// The points of a word to remove because of their neighbours.
struct WordEvidence {
  const DepthPlanes& planes;
  int row;
  int word;

  [[nodiscard]] const Word* at(const BitPlane& plane, int down = 0) const {
    return plane.row(row + down) + word;
  }
  [[nodiscard]] Word trusted(int down = 0) const { return *at(planes.trusted, down); }
  [[nodiscard]] Word linked_below(int down = 0) const {
    return *at(planes.to_below, down) & trusted(down) & trusted(down + 1);
  }
  [[nodiscard]] Word bent_across(int down = 0) const {
    return *at(planes.bent_across, down) & trusted(down - 1) & trusted(down) & trusted(down + 1);
  }

  /// At the end of a surface, or next to it, and off its extrapolation.
  [[nodiscard]] Word mixed() const {
    const Word* const linked = at(planes.to_right);
    const Word* const bent = at(planes.bent_along);
    return trusted() & ((~(linked[0] & after(linked)) & before(bent)) |
                        (~(before(linked) & before(linked, 2)) & after(bent)) |
                        (~(linked_below() & linked_below(1)) & bent_across(-1)) |
                        (~(linked_below(-1) & linked_below(-2)) & bent_across(1)));
  }
  /// Beside a point to which they are not linked.
  [[nodiscard]] Word at_edge() const {
    const Word* const points = at(planes.trusted);
    const Word* const linked = at(planes.to_right);
    return trusted() & ((after(points) & ~linked[0]) | (before(points) & ~before(linked)) |
                        (trusted(1) & ~linked_below()) | (trusted(-1) & ~linked_below(-1)));
  }
  /// With an edge near on both sides, in the row or the column.
  [[nodiscard]] Word thin() const {
    const Word* const linked = at(planes.to_right);
    const Word right = linked[0] & after(linked) & after(linked, 2) & after(linked, 3);
    const Word left = before(linked) & before(linked, 2) & before(linked, 3) & before(linked, 4);
    const Word down = linked_below() & linked_below(1) & *at(planes.to_below, 2);
    const Word up = linked_below(-1) & linked_below(-2);
    return trusted() & (~(right | left) | ~(down | up));
  }
  /// Surrounded by points: linked to all four but off them in row and column, or linked to none.
  [[nodiscard]] Word outliers() const {
    const Word* const points = at(planes.trusted);
    const Word* const linked = at(planes.to_right);
    const Word right = linked[0], left = before(linked), down = linked_below(),
               up = linked_below(-1);
    const Word bent_in_both = right & left & down & up & *at(planes.bent_along) & bent_across();
    const Word surrounded = before(points) & after(points) & trusted(-1) & trusted(1);
    return trusted() & (bent_in_both | (surrounded & ~(right | left | down | up)));
  }
};

}  // namespace

void require_valid(const CleanSettings& settings) {
  require_in_range(settings);
  for (std::size_t axis = 0; settings.box && axis < 3; ++axis) {
    require_in_range(settings.box->largest[axis] > settings.box->least[axis], "end of the box",
                     settings.box->largest[axis], "more than its start");
  }
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
  BitPlane mixed, wire, kept;
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

  [[nodiscard]] int words() const { return BitPlane::words_of(cloud.size()); }

  /// Calls `body(row, counts)` for every row, on all threads.
  template <class Body>
  void for_each_row_counting(const Body& body) {
    constexpr int band_rows = 64;
    const int height = cloud.size().height, bands = (height + band_rows - 1) / band_rows;
    memory.counts.assign(static_cast<std::size_t>(bands), {});
    const auto run_band = [&](int band) {
      const int end = std::min(height, (band + 1) * band_rows);
      ValidityCounts& counted = memory.counts[static_cast<std::size_t>(band)];
      for (int row = band * band_rows; row < end; ++row) body(row, counted);
    };
    if (bands == 1) {
      run_band(0);
    } else {
      for_each_row(bands, [&run_band](int band) { run_band(band); });
    }
    for (const ValidityCounts& counted : memory.counts) {
      for (std::size_t i = 0; i < validity_count; ++i) counts[i] += counted[i];
    }
  }

  void drop_bits(Word bits, int row, int word, Validity reason, ValidityCounts& counted) const {
    for_each_bit(bits, word, [&](int column) { cloud.leave_out(column, row, reason); });
    counted[static_cast<std::size_t>(reason)] += static_cast<std::size_t>(std::popcount(bits));
  }

  void compare(int row) {
    const int last = cloud.size().height - 1;
    const auto depths = [&](int near) {
      return near < 0 || near > last ? memory.beyond.first() : cloud.z.row(near);
    };
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
    const Word* const trusted = planes.trusted.row(row);
    Word* const to_right = planes.to_right.row(row);
    for (int w = 0; w < words(); ++w) {
      const Word both = trusted[w] & after(trusted + w);
      to_right[w] &= both;
      planes.bent_along.row(row)[w] &= both & before(trusted + w);
    }
  }

  /// Whether a pixel at an edge between distant surfaces has less modulation than its neighbours:
  /// it sees both, and their fringes partly cancel.
  [[nodiscard]] bool is_dim(int column, int row) const {
    constexpr float far = 0.05F, dim = 0.75F;  // of the depth; of the brightest
    const int left = std::max(column - 1, 0), right = std::min(column + 1, cloud.z.width() - 1);
    const int above = std::max(row - 1, 0), below = std::min(row + 1, cloud.z.height() - 1);
    const float z = cloud.z(column, row);
    float nearest = z, farthest = z;
    for (int y = above; y <= below; ++y) {
      const float* const depths = cloud.z.row(y);
      for (int x = left; x <= right; ++x) {  // no point, NaN, compares false
        if (depths[x] < nearest) nearest = depths[x];
        if (depths[x] > farthest) farthest = depths[x];
      }
    }
    if (farthest - z <= far * z && z - nearest <= far * z) return false;
    float brightest = 0;
    for (int y = above; y <= below; ++y) {
      for (int x = left; x <= right; ++x) brightest = std::max(brightest, (*modulation)(x, y));
    }
    return (*modulation)(column, row) < dim * brightest;
  }

  /// Whether a farther surface begins within the width of a wire in that direction.
  [[nodiscard]] bool ends_before_wall(int column, int row, int right, int down) const {
    constexpr int widest = 4, reach = 7;  // pixels: three, across; mixed ones may be missing
    const float z = cloud.z(column, row), step = limits.step * z;
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

  /// Call before removing points, since it reads depths of other rows.
  void find_mixed(int row) {
    for (int w = 0; w < words(); ++w) {
      const WordEvidence evidence{memory.planes, row, w};
      Word mixed = evidence.mixed();
      if (modulation != nullptr) {
        for_each_bit(evidence.at_edge() & ~mixed, w, [&](int column) {
          mixed |= Word{is_dim(column, row)} << column % word_pixels;
        });
      }
      Word wire = 0;  // without modulation nothing tells them from curtains of equal mixtures
      for_each_bit(modulation != nullptr ? evidence.thin() : 0, w,
                   [&](int column) { wire |= Word{is_wire(column, row)} << column % word_pixels; });
      memory.wire.row(row)[w] = wire;
      mixed &= ~wire;
      memory.mixed.row(row)[w] = mixed;
    }
  }

  /// Low trust, mixed pixels and outliers.
  void judge(int row, ValidityCounts& counted) {
    for (int w = 0; w < words(); ++w) {
      const WordEvidence evidence{memory.planes, row, w};
      const Word trusted = evidence.trusted();
      const Word mixed = *evidence.at(memory.mixed);
      const Word outliers =
          settings.drop_outliers ? evidence.outliers() & ~(mixed | *evidence.at(memory.wire)) : 0;
      memory.kept.row(row)[w] = trusted & ~(mixed | outliers);
      const Word untrusted = *evidence.at(memory.planes.point) & ~trusted;
      if ((untrusted | mixed | outliers) == 0) continue;
      drop_bits(untrusted, row, w, Validity::low_trust, counted);
      drop_bits(mixed, row, w, Validity::mixed, counted);
      drop_bits(outliers, row, w, Validity::outlier, counted);
    }
  }

  void drop_small_components() {
    const DepthPlanes& planes = memory.planes;
    memory.components.find(cloud.size(), memory.kept, planes.to_right, planes.to_below);
    memory.components.for_each_run_below(settings.smallest_component, [&](const PixelRun& run) {
      const Word* const wire = memory.wire.row(run.row);
      for (int column = run.first; column <= run.last; ++column) {
        if ((wire[column / word_pixels] >> column % word_pixels & 1) != 0) continue;
        cloud.leave_out(column, run.row, Validity::small_component);
        ++counts[static_cast<std::size_t>(Validity::small_component)];
      }
    });
  }

  void drop_outside() {
    if (!settings.box && settings.outline.empty()) return;
    if (!settings.outline.empty() && memory.outline.size() != cloud.size()) {
      memory.outline = outline_mask(settings.outline, cloud.size());
    }
    for_each_row_counting([&](int row, ValidityCounts& counted) {
      for (int column = 0; column < cloud.size().width; ++column) {
        const bool outlined = settings.outline.empty() || memory.outline(column, row) != 0;
        if (!(cloud.z(column, row) > 0)) continue;
        if (outlined && (!settings.box || is_inside(*settings.box, cloud, column, row))) continue;
        cloud.leave_out(column, row, Validity::outside_region);
        ++counted[static_cast<std::size_t>(Validity::outside_region)];
      }
    });
  }

  ValidityCounts run() {
    const Size size = cloud.size();
    memory.planes.prepare(size);
    memory.mixed.prepare(size);
    memory.wire.prepare(size);
    memory.kept.prepare(size);
    memory.beyond.copy(nullptr, size.width);
    memory.first.copy(cloud.z.row(0), size.width);
    memory.last.copy(cloud.z.row(size.height - 1), size.width);
    for_each_row_counting([&](int row, ValidityCounts&) { compare(row); });
    if (settings.drop_mixed) {
      for_each_row_counting([&](int row, ValidityCounts&) { find_mixed(row); });
    } else {
      memory.mixed.clear();
      memory.wire.clear();
    }
    for_each_row_counting([&](int row, ValidityCounts& counted) { judge(row, counted); });
    if (settings.smallest_component > 1) drop_small_components();
    drop_outside();
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

bool Cleaner::wants_modulation() const {
  return !settings_.largest_sigma || std::isfinite(*settings_.largest_sigma);
}

ValidityCounts Cleaner::operator()(Cloud& cloud, const Image<float>* modulation,
                                   const DepthNoise& noise) {
  if (cloud.z.empty() || settings_ == CleanSettings::none()) return {};
  return Pass{.settings = settings_,
              .memory = *memory_,
              .cloud = cloud,
              .limits = depth_limits(cloud, memory_->samples),
              .trust = trust_stage(settings_, noise),
              .modulation = wants_modulation() ? modulation : nullptr}
      .run();
}

}  // namespace slipstream
