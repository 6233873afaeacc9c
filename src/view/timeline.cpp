#include "view/timeline.h"

#include <string>

#include <fmt/format.h>
#include <imgui.h>

namespace slipstream::view {

float timeline_height(const PanelState& state, const ViewSource& source) {
  const bool is_shown = state.shown && source.scans > 1;
  return is_shown ? ImGui::GetFrameHeight() + 2 * ImGui::GetStyle().WindowPadding.y : 0;
}

void draw_timeline(PanelState& state, PanelRequests& requests, const ViewSource& source,
                   const Area& area) {
  const float height = timeline_height(state, source);
  if (height <= 0) return;

  ImGui::SetNextWindowPos({area.left, area.top + area.height - height});
  ImGui::SetNextWindowSize({area.width, height});
  if (ImGui::Begin("timeline", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove)) {
    // Play, and steps to either side.
    state.plays ^= ImGui::Button(state.plays ? "Stop (Space)" : "Play (Space)");
    ImGui::SameLine();
    if (ImGui::ArrowButton("before", ImGuiDir_Left))
      requests.scan = scan_after(state.scan, source, -1);
    ImGui::SameLine();
    if (ImGui::ArrowButton("after", ImGuiDir_Right))
      requests.scan = scan_after(state.scan, source, 1);

    // All scans, by number and time.
    const double seconds = static_cast<double>(state.scan) * source.seconds_per_scan;
    const std::string place = fmt::format("%d of {}, {:.2f} s", source.scans, seconds);
    int number = static_cast<int>(state.scan) + 1;
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1);
    if (ImGui::SliderInt("##scan", &number, 1, static_cast<int>(source.scans), place.c_str(),
                         ImGuiSliderFlags_AlwaysClamp)) {
      requests.scan = static_cast<std::size_t>(number) - 1;
    }
  }
  ImGui::End();
}

std::size_t scan_after(std::size_t scan, const ViewSource& source, int steps) {
  const auto count = static_cast<std::ptrdiff_t>(source.scans);
  const auto place = static_cast<std::ptrdiff_t>(scan) + steps;
  return static_cast<std::size_t>((place + count) % count);
}

}  // namespace slipstream::view
