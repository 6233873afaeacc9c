#include "base/moving_mean.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "base/moving_mean.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A line of numbers `stride` apart, and for each 1 / (count of numbers within `reach`).
struct Line {
  int length;
  std::ptrdiff_t stride;
  int reach;
  const float* inverse;
};

/// Moving mean of adjacent lines, several vectors at once.
template <int vectors, class Tag>
HWY_INLINE void mean_along(Tag d, const float* from, float* to, Line line) {
  const auto [length, stride, reach, inverse] = line;
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));

  // 1. The first window, without the number that enters at place 0.
  hn::Vec<Tag> sum[vectors];
  for (auto& one : sum) one = hn::Zero(d);
  for (int at = 0; at < std::min(reach, length); ++at) {
    const float* const enters = from + at * stride;
    for (int i = 0; i < vectors; ++i) sum[i] = hn::Add(sum[i], hn::LoadU(d, enters + i * lanes));
  }

  // 2. Move the window: add the number that enters, subtract the one that leaves.
  for (int at = 0; at < length; ++at) {
    const float* const enters = from + (at + reach) * stride;
    const float* const leaves = from + (at - reach - 1) * stride;

    const bool more = at + reach < length;
    const bool less = at - reach > 0;

    const auto scale = hn::Set(d, inverse[at]);
    for (int i = 0; i < vectors; ++i) {
      if (more) sum[i] = hn::Add(sum[i], hn::LoadU(d, enters + i * lanes));
      if (less) sum[i] = hn::Sub(sum[i], hn::LoadU(d, leaves + i * lanes));
      hn::StoreU(hn::Mul(sum[i], scale), d, to + at * stride + i * lanes);
    }
  }
}

/// All three passes over `count` adjacent lines; both arrays are overwritten, the result is in
/// `other`.
template <int vectors, class Tag>
HWY_INLINE void smooth(Tag d, int count, float* lines, float* other, Line line) {
  for (int i = 0; i < count; i += vectors * static_cast<int>(hn::Lanes(d))) {
    mean_along<vectors>(d, lines + i, other + i, line);
    mean_along<vectors>(d, other + i, lines + i, line);
    mean_along<vectors>(d, lines + i, other + i, line);
  }
}

constexpr int group = 16;  // lines
using Vectors = hn::CappedTag<float, group / 2>;

/// Transposes a 4 x 4 block.
HWY_INLINE void turn(const float* from, std::ptrdiff_t stride, float* to,
                     std::ptrdiff_t to_stride) {
#if HWY_TARGET == HWY_SCALAR
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) to[j * to_stride + i] = from[i * stride + j];
  }
#else
  const hn::FixedTag<float, 4> d;
  const auto a = hn::LoadU(d, from), b = hn::LoadU(d, from + stride),
             e = hn::LoadU(d, from + 2 * stride), f = hn::LoadU(d, from + 3 * stride);

  const auto ab = hn::InterleaveLower(d, a, b), ef = hn::InterleaveLower(d, e, f);
  const auto last_ab = hn::InterleaveUpper(d, a, b), last_ef = hn::InterleaveUpper(d, e, f);

  hn::StoreU(hn::ConcatLowerLower(d, ef, ab), d, to);
  hn::StoreU(hn::ConcatUpperUpper(d, ef, ab), d, to + to_stride);
  hn::StoreU(hn::ConcatLowerLower(d, last_ef, last_ab), d, to + 2 * to_stride);
  hn::StoreU(hn::ConcatUpperUpper(d, last_ef, last_ab), d, to + 3 * to_stride);
#endif
}

/// Moving means along sixteen rows; `lines` and `other` are scratch of sixteen rows each.
void SmoothRows(float* rows, int width, int reach, const float* inverse, float* lines,
                float* other) {
  // 1. Transpose the rows, so that a vector holds one column of several; the last columns one by
  //    one.
  constexpr int count = group;
  const int whole = width / 4 * 4;
  for (int column = 0; column < whole; column += 4) {
    for (int i = 0; i < count; i += 4) {
      turn(rows + std::ptrdiff_t{i} * width + column, width, lines + column * count + i, count);
    }
  }
  for (int column = whole; column < width; ++column) {
    for (int i = 0; i < count; ++i) lines[column * count + i] = rows[i * width + column];
  }

  // 2. Smooth.
  smooth<2>(Vectors(), count, lines, other, {width, count, reach, inverse});

  // 3. Transpose back.
  for (int column = 0; column < whole; column += 4) {
    for (int i = 0; i < count; i += 4) {
      turn(other + column * count + i, count, rows + std::ptrdiff_t{i} * width + column, width);
    }
  }
  for (int column = whole; column < width; ++column) {
    for (int i = 0; i < count; ++i) rows[i * width + column] = other[column * count + i];
  }
}

/// Moving means along the columns [first, last); the result is in `other`.
void SmoothColumns(float* picture, float* other, Size size, int first, int last, int reach,
                   const float* inverse) {
  const Line line{size.height, size.width, reach, inverse};
  const int whole = (last - first) / group * group;

  // Whole groups of columns, then the rest one by one.
  smooth<2>(Vectors(), whole, picture + first, other + first, line);
  smooth<1>(hn::CappedTag<float, 1>(), last - first - whole, picture + first + whole,
            other + first + whole, line);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {
HWY_EXPORT(SmoothRows);
HWY_EXPORT(SmoothColumns);

namespace {

/// For each place of a line, 1 / (count of places within `reach`).
std::vector<float> inverse_counts(int length, int reach) {
  std::vector<float> inverse(static_cast<std::size_t>(length));
  for (int i = 0; i < length; ++i) {
    const int count = std::min(i + reach, length - 1) - std::max(i - reach, 0) + 1;
    inverse[static_cast<std::size_t>(i)] = 1 / static_cast<float>(count);
  }
  return inverse;
}

}  // namespace

int odd_length(double length) {
  constexpr double longest = 1e6;
  return 2 * static_cast<int>(std::lround((std::clamp(length, 1.0, longest) - 1) / 2)) + 1;
}

void take_moving_mean(Image<float>& picture, Size window, Image<float>& scratch) {
  const auto [width, height] = picture.size();
  const int beside = window.width / 2, above = window.height / 2;
  if (scratch.size() != picture.size()) scratch = Image<float>(picture.size());

  const std::vector<float> along = inverse_counts(width, beside),
                           down = inverse_counts(height, above);

  // A vector holds adjacent lines, so rows are transposed to columns in groups of sixteen.
  constexpr int group = 16, wide = 64;
  for_each_row((height + group - 1) / group, [&](int block) {
    const int first = block * group, rows = std::min(group, height - first);

    thread_local std::vector<float> group_rows, lines;
    lines.resize(2 * static_cast<std::size_t>(width) * group);

    // The last group may have fewer rows: pad a copy.
    float* from = picture.row(first);
    if (rows < group) {
      group_rows.assign(static_cast<std::size_t>(width) * group, 0);
      std::copy_n(from, rows * width, group_rows.data());
      from = group_rows.data();
    }

    HWY_DYNAMIC_DISPATCH(SmoothRows)
    (from, width, beside, along.data(), lines.data(), lines.data() + width * group);
    if (rows < group) std::copy_n(from, rows * width, picture.row(first));
  });

  // Columns already lie side by side.
  for_each_row((width + wide - 1) / wide, [&](int block) {
    const int first = block * wide, last = std::min(first + wide, width);
    HWY_DYNAMIC_DISPATCH(SmoothColumns)
    (picture.row(0), scratch.row(0), picture.size(), first, last, above, down.data());
  });

  std::swap(picture, scratch);
}

}  // namespace slipstream
#endif
