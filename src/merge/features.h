#pragma once

#include <vector>

#include <Eigen/Core>

#include "merge/view.h"

namespace slipstream {

/// Histogram of the angles between a point's normal and those around it (fast point feature
/// histogram; Rusu, Blodow and Beetz 2009). Does not change when the view moves.
inline constexpr int feature_bins = 33;
using Features = Eigen::Matrix<float, feature_bins, Eigen::Dynamic>;

/// A view's surface in coarse steps, with a feature for each point.
struct Keypoints {
  float cell = 0;  ///< mm between the points, about
  std::vector<Eigen::Vector3f> points{};
  std::vector<Eigen::Vector3f> normals{};  ///< averaged over about a cell
  Features features{};                     ///< a column for each point
};

/// Keypoints every `cell` mm. Their features describe the surface up to five cells around.
Keypoints keypoints_of(const View& view, float cell);

/// Points of two views with similar surroundings.
struct Correspondence {
  int first = 0, second = 0;  ///< indices of the keypoints
};

/// For each keypoint of either view the two of the other with the most similar features, so that
/// repeated shapes are not missed; at most `most`, the most similar first, those on flat or evenly
/// curved surface last. Of a view with itself: pairs of similar keypoints at different places.
std::vector<Correspondence> similar_keypoints(const Keypoints& first, const Keypoints& second,
                                              std::size_t most);

}  // namespace slipstream
