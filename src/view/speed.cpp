#include "view/speed.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>
#include <imgui.h>

#include "view/widgets.h"

namespace slipstream::view {
namespace {

std::string text_of(const Latency& latency) {
  return fmt::format("{:.1f} / {:.1f} / {:.1f}", latency.p50, latency.p99, latency.max);
}

double rate_of(const LiveStatistics& statistics, std::string_view stage) {
  const auto found = std::ranges::find(statistics.stages, stage, &StageStatistics::name);
  return found == statistics.stages.end() ? 0 : found->rate;
}

void draw_rates(const PanelState& state, const LiveStatistics& statistics) {
  const LiveStatistics::Frames& frames = statistics.frames;

  row("frames", fmt::format("{:.1f} per s", rate_of(statistics, "capture")));
  row("scans", fmt::format("{:.1f} per s", rate_of(statistics, "reconstruct")));
  row("pictures drawn", fmt::format("{:.1f} per s", state.drawn_per_second));
  row("frames lost", fmt::format("{} of {}", frames.lost, frames.captured + frames.lost),
      frames.lost == 0 ? good : bad);

  // A row for each figure that names a trouble, unless it is 0.
  const auto bad_news = [](const char*, const auto& value, const char* trouble = "") {
    if constexpr (std::is_same_v<decltype(value), const std::uint64_t&>) {
      if (*trouble != '\0' && value != 0) row(trouble, fmt::format("{}", value), bad);
    }
  };
  frames.for_each_figure(bad_news);
  statistics.for_each_figure(bad_news);

  if (statistics.motion > 0) row("extra frames for motion", fmt::format("{}", statistics.motion));
}

void draw_latencies(const LiveStatistics& statistics) {
  if (!ImGui::TreeNode("delay since capture, ms")) return;

  table("latencies", 2, ImGuiTableFlags_SizingStretchProp, [&] {
    row("", "median / 99th percentile / longest", quiet);
    row("to points", text_of(statistics.latency));
    row("to screen", text_of(statistics.screen_latency));
  });

  ImGui::TreePop();
}

void draw_stages(const LiveStatistics& statistics) {
  if (statistics.stages.empty() || !ImGui::TreeNode("threads")) return;
  table("stages", 4, ImGuiTableFlags_SizingStretchProp, [&] {
    // A heading, and a line for each thread.
    for (const char* const title : {"", "per s", "waiting", "ms"}) {
      ImGui::TableNextColumn();
      say(quiet, "{}", title);
    }

    for (const StageStatistics& stage : statistics.stages) {
      row(stage.name.c_str(), fmt::format("{:.1f}", stage.rate));
      ImGui::TableNextColumn();
      say(white, "{}/{}", stage.waiting, stage.capacity);
      ImGui::TableNextColumn();
      say(white, "{:.1f}", stage.latency.p99);
    }
  });
  ImGui::TreePop();
}

}  // namespace

void draw_speed(const PanelState& state, const LiveStatistics& statistics) {
  if (!section("Speed")) return;

  table("rates", 2, ImGuiTableFlags_SizingStretchProp, [&] { draw_rates(state, statistics); });
  draw_latencies(statistics);
  draw_stages(statistics);
}

}  // namespace slipstream::view
