#include "app/merge_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/page.h"
#include "base/statistics.h"
#include "io/canvas.h"
#include "io/image_file.h"

namespace slipstream::app {
namespace {

constexpr Colour background{250, 250, 250}, ink{40, 40, 40};

/// The views on a circle, joined by lines as wide as the surface they share is large.
Canvas overlap_graph(std::size_t views, const JointAlignment& joint) {
  constexpr int side = 420;
  constexpr double radius = 180, widest = 9, dot = 22;
  constexpr Colour good{46, 158, 79}, left_out{207, 58, 46};

  Canvas canvas({side, side}, background);
  const auto place = [&](std::size_t view) {
    const double angle =
        2 * std::numbers::pi * static_cast<double>(view) / static_cast<double>(views);
    return CanvasPoint{side / 2.0 + radius * std::sin(angle),
                       side / 2.0 - radius * std::cos(angle)};
  };

  for (const ViewLink& link : joint.links) {
    draw_line(canvas, place(link.first), place(link.second),
              1 + (widest - 1) * link.alignment.overlap, {150, 180, 215});
  }
  for (std::size_t i = 0; i < views; ++i) {
    const CanvasPoint at = place(i);
    draw_line(canvas, at, at, dot, joint.poses[i] ? good : left_out);
    const std::string number = std::to_string(i + 1);
    draw_text(canvas, number, {at.x - text_width(number) / 2, at.y + 4}, {255, 255, 255});
  }
  return canvas;
}

/// The model seen along an axis, each point in the colour of its views' disagreement up to `most`.
Canvas picture_of(const FusedModel& model, int across, int down, int depth, float most) {
  constexpr int longest = 480;

  Eigen::Vector3f low = Eigen::Vector3f::Constant(1e9F), high = -low;
  for (const ModelPoint& point : model.points) {
    low = low.cwiseMin(point.position);
    high = high.cwiseMax(point.position);
  }
  const Eigen::Vector3f extent = high - low;
  const float pixel = std::max({extent(across), extent(down), 1e-3F}) / (longest - 1);
  const Size size{static_cast<int>(extent(across) / pixel) + 1,
                  static_cast<int>(extent(down) / pixel) + 1};

  // The nearest point of each pixel, drawn as large as the spacing.
  Canvas canvas(size, background);
  Image<float> nearest(size, 1e9F);
  const int half = std::max(static_cast<int>(model.spacing / pixel / 2), 0);
  const ColourMap colours = depth_colours();
  for (const ModelPoint& point : model.points) {
    const Eigen::Vector3f at = point.position - low;
    const auto column = static_cast<int>(at(across) / pixel);
    const auto row = static_cast<int>(at(down) / pixel);
    // One view has nothing to disagree with.
    constexpr Colour alone{190, 190, 190};
    const float share = std::clamp(point.disagreement / most, 0.0F, 1.0F);
    const Colour colour =
        point.views < 2 ? alone : colours[static_cast<std::size_t>(170 - 170 * share)];
    for (int y = std::max(row - half, 0); y <= std::min(row + half, size.height - 1); ++y) {
      for (int x = std::max(column - half, 0); x <= std::min(column + half, size.width - 1); ++x) {
        if (at(depth) >= nearest(x, y)) continue;
        nearest(x, y) = at(depth);
        canvas(x, y) = colour;
      }
    }
  }
  return canvas;
}

void add_pairs(const std::vector<std::string>& names, const JointAlignment& joint, Page& page) {
  page.heading("Pairs");
  page.paragraph(
      "Distances between both surfaces along their normals, at the joint poses, mm. Noise: the "
      "median that the points' standard deviations predict.");
  page.table({"views", "overlap", "median", "95 %", "noise", "from the pair alone", ""});
  for (const ViewLink& link : joint.links) {
    const PairAlignment& fit = link.alignment;
    page.row({fmt::format("{}, {}", names[link.first], names[link.second]),
              fmt::format("{:.0f} %", 100 * fit.overlap), fmt::format("{:.3f}", fit.median),
              fmt::format("{:.3f}", fit.percentile_95), fmt::format("{:.3f}", fit.noise),
              fmt::format("{:.3f}", link.loop_error), link.closes_loop ? "closes a loop" : ""});
  }
  if (joint.refused.empty()) return;

  page.heading("Pairs that were not joined");
  page.table({"views", "reason"});
  for (const ViewLink& link : joint.refused) {
    page.row({fmt::format("{}, {}", names[link.first], names[link.second]), link.alignment.reason});
  }
}

void add_pictures(const FusedModel& model, Page& page) {
  std::vector<float> disagreements;
  for (const ModelPoint& point : model.points) {
    if (point.views > 1) disagreements.push_back(point.disagreement);
  }
  if (disagreements.empty()) return;

  const float middle = quantile(disagreements, 0.5), most = quantile(disagreements, 0.95);
  page.heading("Where the views disagree");
  page.paragraph(
      "Largest distance between two views' surfaces at each point: {:.3f} mm in the median, {:.3f} "
      "mm at 95 %. Violet: none; red: {:.3f} mm or more; grey: seen by one view.",
      middle, most, most);
  const float scale = std::max(most, 1e-6F);
  page.picture("along z", "merge-z.png", picture_of(model, 0, 1, 2, scale));
  page.picture("along x", "merge-x.png", picture_of(model, 2, 1, 0, scale));
  page.picture("along y", "merge-y.png", picture_of(model, 0, 2, 1, scale));
}

}  // namespace

void write_merge_report(const std::string& path, const std::vector<std::string>& names,
                        const JointAlignment& joint, const FusedModel& model) {
  Page page("Merged views");
  const bool whole = joint.joined() == names.size();
  page.verdict(
      {whole ? "good" : "bad", fmt::format("{} of {} views joined; {} points", joint.joined(),
                                           names.size(), model.points.size())});
  if (joint.loop_error) {
    page.paragraph(
        "Loop error: {:.3f} mm and {:.4f} degrees (RMS over the pairs that close a loop, before "
        "the "
        "joint refinement).",
        *joint.loop_error, *joint.loop_turn);
  } else {
    page.paragraph("No pair closes a loop, so that errors of the poses add up unseen.");
  }

  page.heading("Views");
  page.table({"", "view", ""});
  for (std::size_t i = 0; i < names.size(); ++i) {
    page.row({std::to_string(i + 1), names[i], joint.reasons[i]});
  }
  page.picture("Overlap of the views", "merge-overlap.png", overlap_graph(names.size(), joint));

  add_pairs(names, joint, page);
  add_pictures(model, page);
  write_page(path, page, PageFiles::page_alone);
}

}  // namespace slipstream::app
