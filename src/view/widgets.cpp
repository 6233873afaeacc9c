#include "view/widgets.h"

#include <string>

#include <imgui.h>

namespace slipstream::view {

bool section(const char* name) {
  return ImGui::CollapsingHeader(name, ImGuiTreeNodeFlags_DefaultOpen);
}

void name_field(const char* name) {
  constexpr float share = 0.38F;  // of the panel
  const float left = ImGui::GetCursorPosX();

  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(quiet, "%s", name);
  ImGui::SameLine(left + share * ImGui::GetWindowWidth());
  ImGui::SetNextItemWidth(-1);
}

bool large_button(const char* name) {
  ImGui::PushStyleColor(ImGuiCol_Button, primary);
  const bool pressed = ImGui::Button(name, {-1, 2.2F * ImGui::GetFontSize()});
  ImGui::PopStyleColor();
  return pressed;
}

void tell_help(const char* help) {
  if (!ImGui::IsItemHovered()) return;

  ImGui::SetNextWindowPos(
      {ImGui::GetWindowPos().x + ImGui::GetWindowWidth(), ImGui::GetItemRectMin().y});
  ImGui::SetTooltip("%s", help);
}

void row(const char* name, const std::string& value, const ImVec4& colour) {
  ImGui::TableNextRow();

  ImGui::TableNextColumn();

  ImGui::TextColored(quiet, "%s", name);
  ImGui::TableNextColumn();
  ImGui::TextColored(colour, "%s", value.c_str());
}

}  // namespace slipstream::view
