#include "slipstream/image/moving_mean.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "slipstream/image/parallel_rows.h"

namespace slipstream {
namespace {

/// One over how many places of a line are within `reach` of each.
std::vector<float> inverse_counts(int length, int reach) {
  std::vector<float> inverse(static_cast<std::size_t>(length));
  for (int i = 0; i < length; ++i) {
    const int count = std::min(i + reach, length - 1) - std::max(i - reach, 0) + 1;
    inverse[static_cast<std::size_t>(i)] = 1 / static_cast<float>(count);
  }
  return inverse;
}

/// `lanes` lines side by side, place after place `stride` apart: each to the mean about it.
template <int lanes>
void mean_along(const float* from, float* to, int length, std::ptrdiff_t stride, int reach,
                const float* inverse) {
  float sum[lanes] = {};
  const auto add = [&](const float* place, float sign) {
    for (int i = 0; i < lanes; ++i) sum[i] += sign * place[i];
  };
  for (int at = 0; at < std::min(reach, length); ++at) add(from + at * stride, 1);
  for (int at = 0; at < length; ++at) {
    if (at + reach < length) add(from + (at + reach) * stride, 1);
    if (at - reach > 0) add(from + (at - reach - 1) * stride, -1);
    for (int i = 0; i < lanes; ++i) to[at * stride + i] = sum[i] * inverse[at];
  }
}

/// All passes over some lines; `line` and `other` hold them, the result is in `other`.
template <int lanes>
void smooth(float* line, float* other, int length, std::ptrdiff_t stride, int reach,
            const float* inverse) {
  mean_along<lanes>(line, other, length, stride, reach, inverse);
  mean_along<lanes>(other, line, length, stride, reach, inverse);
  mean_along<lanes>(line, other, length, stride, reach, inverse);
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
  // Lines side by side are vectors: rows are turned to columns in small groups.
  constexpr int group = 16;
  for_each_row((height + group - 1) / group, [&](int block) {
    const int first = block * group, rows = std::min(group, height - first);
    thread_local std::vector<float> turned;
    turned.resize(2 * static_cast<std::size_t>(width) * group);
    for (int i = 0; i < rows; ++i) {
      const float* const row = picture.row(first + i);
      for (int column = 0; column < width; ++column) {
        turned[static_cast<std::size_t>(column * group + i)] = row[column];
      }
    }
    float* const result = turned.data() + width * group;
    smooth<group>(turned.data(), result, width, group, beside, along.data());
    for (int i = 0; i < rows; ++i) {
      float* const row = picture.row(first + i);
      for (int column = 0; column < width; ++column) {
        row[column] = result[column * group + i];
      }
    }
  });
  constexpr int wide = 64;
  for_each_row((width + wide - 1) / wide, [&](int block) {
    const int first = block * wide, columns = std::min(wide, width - first);
    float *const line = picture.row(0) + first, *const other = scratch.row(0) + first;
    if (columns == wide) {
      smooth<wide>(line, other, height, width, above, down.data());
    } else {
      for (int i = 0; i < columns; ++i) {
        smooth<1>(line + i, other + i, height, width, above, down.data());
      }
    }
  });
  std::swap(picture, scratch);
}

}  // namespace slipstream
