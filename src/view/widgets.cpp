#include "view/widgets.h"

#include <string>

#include <imgui.h>

namespace slipstream::view {

bool section(const char* name) {
  return ImGui::CollapsingHeader(name, ImGuiTreeNodeFlags_DefaultOpen);
}

void row(const char* name, const std::string& value, const ImVec4& colour) {
  ImGui::TableNextRow();

  ImGui::TableNextColumn();

  ImGui::TextColored(quiet, "%s", name);
  ImGui::TableNextColumn();
  ImGui::TextColored(colour, "%s", value.c_str());
}

}  // namespace slipstream::view
