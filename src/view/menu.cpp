#include "view/menu.h"

#include <array>
#include <utility>

#include <imgui.h>

#include "view/widgets.h"

namespace slipstream::view {
namespace {

/// The mouse, and keys that the menus name only in some windows or not at all.
constexpr std::array<std::pair<const char*, const char*>, 11> mouse_and_keys{{
    {"drag", "rotate"},
    {"right drag, Shift and drag", "move"},
    {"wheel", "zoom"},
    {"1, 2, 3, 8", "colour by depth, reflectivity, modulation, camera"},
    {"M", "measure with the mouse"},
    {"Space", "pause; play a recording"},
    {"Left, Right", "step through a recording"},
    {"S, R", "save the scan, record"},
    {"G", "live on a monitor: compare the rig with its calibration"},
    {"L, C, E", "studio: live, calibrate, best exposure"},
    {"Esc, Enter", "close"},
}};

void draw_file_menu(PanelState& state, PanelRequests& requests, const ViewSource& source) {
  if (!ImGui::BeginMenu("File")) return;

  if (source.open && ImGui::MenuItem("Open ...", "O")) {
    requests.file = {FileQuestion::open, state.path.data()};
  }
  if (source.save) {
    requests.save |= ImGui::MenuItem(source.opens_saved ? "Capture" : "Save scan", "S");
  }
  if (ImGui::MenuItem("Save cloud as ...", nullptr, false, has_points(state, source))) {
    requests.file = {FileQuestion::save, state.path.data()};
  }
  if (ImGui::MenuItem("Close", "Esc")) state.closing = true;
  ImGui::EndMenu();
}

void draw_view_menu(PanelState& state, PanelRequests& requests) {
  if (!ImGui::BeginMenu("View")) return;

  int viewpoint = 0;
  for (const auto& [name, key] : {std::pair("Front", "4"), {"Side", "5"}, {"Top", "6"}}) {
    if (ImGui::MenuItem(name, key)) requests.viewpoint = static_cast<Viewpoint>(viewpoint);
    ++viewpoint;
  }
  ImGui::MenuItem("Front, side and top", "7", &state.view.three_views);
  requests.fit |= ImGui::MenuItem("Fit", "F");
  if (ImGui::MenuItem("Hide panel and menus", "Tab")) state.shown = false;
  ImGui::EndMenu();
}

}  // namespace

void draw_menus(PanelState& state, PanelRequests& requests, const ViewSource& source) {
  if (ImGui::BeginMainMenuBar()) {
    draw_file_menu(state, requests, source);
    if (ImGui::BeginMenu("Edit")) {
      requests.undo |= ImGui::MenuItem("Undo change of settings", "Z", false, state.can_undo);
      ImGui::EndMenu();
    }
    draw_view_menu(state, requests);
    if (ImGui::BeginMenu("Help")) {
      ImGui::MenuItem("Mouse and keys", nullptr, &state.shows_keys);
      ImGui::EndMenu();
    }
    ImGui::EndMainMenuBar();
  }

  if (!state.shows_keys) return;
  constexpr auto flags = ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse;
  const ImVec2 middle = ImGui::GetMainViewport()->GetCenter();
  ImGui::SetNextWindowPos(middle, ImGuiCond_Appearing, {0.5F, 0.5F});
  if (ImGui::Begin("Mouse and keys", &state.shows_keys, flags)) {
    table("keys", 2, ImGuiTableFlags_SizingFixedFit, [] {
      for (const auto& [key, action] : mouse_and_keys) row(key, action);
    });
  }
  ImGui::End();
}

void draw_closing(PanelState& state, PanelRequests& requests, const Screen& screen) {
  if (!state.closing) return;

  ImGui::SetNextWindowPos({0.5F * static_cast<float>(screen.window.width),
                           0.4F * static_cast<float>(screen.window.height)},
                          0, {0.5F, 0.5F});
  constexpr ImGuiWindowFlags question = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                        ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysAutoResize;
  if (ImGui::Begin("closing", nullptr, question)) {
    ImGui::TextUnformatted("Close this window?");
    requests.close |= ImGui::Button("Close (Enter)");
    ImGui::SameLine();
    if (ImGui::Button("Go on (Esc)")) state.closing = false;
  }
  ImGui::End();
}

}  // namespace slipstream::view
