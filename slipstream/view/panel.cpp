#include "slipstream/view/panel.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#include <fmt/format.h>
#include <imgui.h>

namespace slipstream::view {
namespace {

const ImVec4 quiet(0.62F, 0.66F, 0.72F, 1), bad(1.0F, 0.50F, 0.42F, 1),
    doubtful(1.0F, 0.78F, 0.36F, 1), good(0.50F, 0.85F, 0.55F, 1);
constexpr ImGuiWindowFlags fixed_window = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                          ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoTitleBar;

template <class... Values>
void say(const ImVec4& colour, fmt::format_string<Values...> format, Values&&... values) {
  const std::string line = fmt::format(format, std::forward<Values>(values)...);
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(line.c_str());
  ImGui::PopTextWrapPos();
  ImGui::PopStyleColor();
}

bool section(const char* name) {
  return ImGui::CollapsingHeader(name, ImGuiTreeNodeFlags_DefaultOpen);
}

/// A name at the left, what it is at the right of it.
void row(const char* name, const std::string& value, const ImVec4& colour = {1, 1, 1, 1}) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::PushStyleColor(ImGuiCol_Text, quiet);
  ImGui::TextUnformatted(name);
  ImGui::PopStyleColor();
  ImGui::TableNextColumn();
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::TextUnformatted(value.c_str());
  ImGui::PopStyleColor();
}

/// Bad news where there are any.
void count_row(const char* name, std::uint64_t count) {
  if (count != 0) row(name, fmt::format("{}", count), bad);
}

std::string text_of(const Latency& latency) {
  return fmt::format("{:.1f} / {:.1f} / {:.1f}", latency.p50, latency.p99, latency.max);
}

double rate_of(const LiveStatistics& statistics, std::string_view stage) {
  const auto found = std::find_if(statistics.stages.begin(), statistics.stages.end(),
                                  [&](const StageStatistics& s) { return s.name == stage; });
  return found == statistics.stages.end() ? 0 : found->rate;
}

void draw_rates(const PanelState& state, const LiveStatistics& statistics) {
  if (!ImGui::BeginTable("rates", 2, ImGuiTableFlags_SizingStretchProp)) return;
  row("frames", fmt::format("{:.1f} / s", rate_of(statistics, "capture")));
  row("clouds", fmt::format("{:.1f} / s", rate_of(statistics, "reconstruct")));
  row("display", fmt::format("{:.1f} / s", state.drawn_per_second));
  row("lost",
      fmt::format("{} of {} frames", statistics.frames.lost,
                  statistics.frames.captured + statistics.frames.lost),
      statistics.frames.lost == 0 ? good : bad);
  count_row("overwritten", statistics.frames.overwritten);
  count_row("repeated", statistics.frames.repeated);
  count_row("windows lost", statistics.windows_lost);
  count_row("resynchronised", statistics.resynchronisations);
  for (std::size_t i = 1; i < validity_count; ++i) {
    if (statistics.cleaned[i] == 0) continue;
    row(std::string(name_of(static_cast<Validity>(i))).c_str(),
        fmt::format("{} points", statistics.cleaned[i]));
  }
  ImGui::EndTable();
}

void draw_latencies(const LiveStatistics& statistics) {
  if (!ImGui::BeginTable("latencies", 2, ImGuiTableFlags_SizingStretchProp)) return;
  row("ms", "p50 / p99 / max", quiet);
  row("to cloud", text_of(statistics.latency));
  row("to screen", text_of(statistics.screen_latency));
  ImGui::EndTable();
}

void draw_stages(const LiveStatistics& statistics) {
  if (statistics.stages.empty() || !ImGui::TreeNode("stages")) return;
  if (ImGui::BeginTable("stages", 4, ImGuiTableFlags_SizingStretchProp)) {
    for (const char* const title : {"stage", "per s", "queue", "p99 ms"}) {
      ImGui::TableNextColumn();
      say(quiet, "{}", title);
    }
    for (const StageStatistics& stage : statistics.stages) {
      row(stage.name.c_str(), fmt::format("{:.1f}", stage.rate));
      ImGui::TableNextColumn();
      say({1, 1, 1, 1}, "{}/{}", stage.waiting, stage.capacity);
      ImGui::TableNextColumn();
      say({1, 1, 1, 1}, "{:.1f}", stage.latency.p99);
    }
    ImGui::EndTable();
  }
  ImGui::TreePop();
}

/// What is amiss and why, a short line each; the numbers are told elsewhere.
void draw_findings(const std::vector<Finding>& findings) {
  for (const Finding& finding : findings) {
    const ImVec4& colour = finding.gravity == Gravity::wrong ? bad : doubtful;
    say(colour, "{}{}{}", finding.what, finding.likely.empty() ? "" : ": ", finding.likely);
  }
}

void draw_status(const PanelState& state, const ViewSource& source,
                 const LiveStatistics& statistics) {
  if (!statistics.source_state.empty()) say(bad, "{}", statistics.source_state);
  draw_findings(source.findings);
  draw_findings(statistics.findings);
  if (source.statistics && section("Rates")) {
    draw_rates(state, statistics);
    draw_latencies(statistics);
    draw_stages(statistics);
  }
  say(quiet, "{} points of {} pixels", state.points, state.pixels);
}

void draw_view_settings(PanelState& state, PanelRequests& requests) {
  if (!section("Cloud")) return;
  ViewSettings& view = state.view;
  int colour = static_cast<int>(view.colour);
  ImGui::TextUnformatted("colour");
  ImGui::RadioButton("reflectivity", &colour, static_cast<int>(PointColour::reflectivity));
  ImGui::SameLine();
  ImGui::RadioButton("B", &colour, static_cast<int>(PointColour::modulation));
  ImGui::SameLine();
  ImGui::RadioButton("depth", &colour, static_cast<int>(PointColour::depth));
  view.colour = static_cast<PointColour>(colour);
  ImGui::SliderFloat("point size", &view.point_size, 0.3F, 6, "%.1f", ImGuiSliderFlags_Logarithmic);
  ImGui::SliderFloat("brightness", &view.brightness, 0.2F, 5, "%.2f", ImGuiSliderFlags_Logarithmic);
  ImGui::Checkbox("shaded", &view.shaded);
  ImGui::SameLine(0.5F * ImGui::GetWindowWidth());
  ImGui::Checkbox("reflection", &view.reflection);
  ImGui::Checkbox("axes", &view.axes);
  ImGui::SameLine(0.5F * ImGui::GetWindowWidth());
  ImGui::Checkbox("floor", &view.grid);
  if (view.grid) say(quiet, "floor lines every {:g} mm", state.grid_mm);
  requests.fit |= ImGui::Button("Fit (F)");
}

/// One of the labelled choices; whether another was chosen.
template <class Choices>
bool draw_choice(const char* name, const Choices& choices, std::size_t& chosen) {
  if (choices.size() < 2 || chosen >= choices.size()) return false;
  bool changed = false;
  if (ImGui::BeginCombo(name, choices[chosen].first.c_str())) {
    for (std::size_t i = 0; i < choices.size(); ++i) {
      if (ImGui::Selectable(choices[i].first.c_str(), i == chosen) && i != chosen) {
        chosen = i;
        changed = true;
      }
    }
    ImGui::EndCombo();
  }
  return changed;
}

void draw_scan_settings(PanelState& state, PanelRequests& requests, const ViewSource& source) {
  if (!source.setup || !source.change || !section("Scan")) return;
  ReconstructSettings& settings = state.setup.settings;
  if (draw_choice("strategy", source.strategies, state.strategy)) {
    state.setup.sequence.strategy = source.strategies[state.strategy].second;
    requests.change_setup = true;
  }
  if (draw_choice("gamma", source.gammas, state.gamma)) {
    state.setup.scanner.photometry.response = source.gammas[state.gamma].second;
    requests.change_setup = true;
  }
  auto threshold = static_cast<float>(settings.minimum_modulation);
  if (ImGui::SliderFloat("least B", &threshold, 1, 100, "%.0f")) {
    settings.minimum_modulation = static_cast<double>(threshold);
  }
  // Tables are built for every change, so one that is dragged counts when it is let go.
  requests.change_setup |= ImGui::IsItemDeactivatedAfterEdit();
  bool drop = settings.drop_saturated;
  if (ImGui::Checkbox("drop saturated pixels", &drop)) {
    settings.drop_saturated = drop;
    requests.change_setup = true;
  }
}

void draw_actions(PanelState& state, PanelRequests& requests, const ViewSource& source) {
  ImGui::Separator();
  if (source.statistics) {
    state.paused ^= ImGui::Button(state.paused ? "Go on (space)" : "Pause (space)");
  }
  if (source.save) {
    if (source.statistics) ImGui::SameLine();
    requests.save |= ImGui::Button("Save (S)");
  }
  if (source.record) {
    const std::string recording = source.recording ? source.recording() : std::string();
    requests.toggle_recording |= ImGui::Button(recording.empty() ? "Record (R)" : "Stop (R)");
    if (!recording.empty()) say(bad, "recording: {}", recording);
  }
  if (!state.message.empty()) say({1, 1, 1, 1}, "{}", state.message);
}

void place_window(float left, float width, const Screen& screen) {
  ImGui::SetNextWindowPos({left, 0});
  ImGui::SetNextWindowSize({width, static_cast<float>(screen.window.height)});
}

bool has_pictures(const ViewSource& source) {
  return source.setup.has_value();
}

}  // namespace

PanelWidths panel_widths(const PanelState& state, const ViewSource& source, const Screen& screen) {
  if (!state.shown) return {};
  const auto width = static_cast<float>(screen.window.width);
  const float left = std::min(270 * screen.unit(), 0.5F * width);
  const float right = std::min(300 * screen.unit(), 0.3F * width);
  const bool room = width >= 760 * screen.unit();
  return {left, has_pictures(source) && room ? right : 0};
}

void draw_panel(PanelState& state, PanelRequests& requests, const ViewSource& source,
                const LiveStatistics& statistics, const Screen& screen) {
  const PanelWidths widths = panel_widths(state, source, screen);
  if (widths.left <= 0) return;
  place_window(0, widths.left, screen);
  if (ImGui::Begin("panel", nullptr, fixed_window)) {
    ImGui::PushItemWidth(-80 * screen.unit());
    draw_status(state, source, statistics);
    draw_view_settings(state, requests);
    draw_scan_settings(state, requests, source);
    draw_actions(state, requests, source);
    say(quiet, "drag: turn; right drag: move; wheel: zoom; Tab: hide this");
    ImGui::PopItemWidth();
  }
  ImGui::End();
}

void draw_pictures(PanelState& state, const std::array<opengl::PictureTexture, 3>& pictures,
                   const ViewSource& source, const Screen& screen) {
  static constexpr std::array<const char*, 3> titles{"Camera (saturated: red)", "Modulation B",
                                                     "Wrapped phase"};
  const PanelWidths widths = panel_widths(state, source, screen);
  if (widths.right <= 0) return;
  place_window(static_cast<float>(screen.window.width) - widths.right, widths.right, screen);
  if (ImGui::Begin("pictures", nullptr, fixed_window)) {
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      ImGui::SetNextItemOpen(state.picture_open[i]);
      state.picture_open[i] = ImGui::CollapsingHeader(titles[i]);
      const Size size = pictures[i].size();
      if (!state.picture_open[i] || size.width < 1 || size.height < 1) continue;
      const float width = ImGui::GetContentRegionAvail().x;
      const float height = width * static_cast<float>(size.height) / static_cast<float>(size.width);
      // Dear ImGui hands a texture on as whatever its backend takes it for: here OpenGL's number.
      ImGui::Image(std::bit_cast<ImTextureID>(std::uintptr_t{pictures[i].number()}),
                   {width, height});
    }
  }
  ImGui::End();
}

}  // namespace slipstream::view
