#include "view/mouse.h"

#include <glm/geometric.hpp>
#include <imgui.h>

#include "view/orbit_camera.h"

namespace slipstream::view {

void move_camera(PanelState& state, const Pane& pane, const Screen& screen) {
  const ImGuiIO& io = ImGui::GetIO();
  const float height = static_cast<float>(pane.size.height) / screen.pixel_ratio();
  const glm::vec2 drag(io.MouseDelta.x / height, io.MouseDelta.y / height);

  OrbitCamera& camera = state.view.camera;

  if (ImGui::IsMouseDown(ImGuiMouseButton_Left) && !state.measures) {
    camera = io.KeyShift ? panned(camera, drag) : orbited(camera, drag);
  } else if (ImGui::IsMouseDown(ImGuiMouseButton_Right) ||
             ImGui::IsMouseDown(ImGuiMouseButton_Middle)) {
    camera = panned(camera, drag);
  }

  if (io.MouseWheel != 0) camera = zoomed(camera, io.MouseWheel);
}

void measure(PanelState& state, const CloudOnPicture& shown, const Area& area, float pixel_ratio) {
  const auto place_of = [&](const ImVec2& mouse) {
    return pixel_ratio * glm::vec2(mouse.x - area.left, mouse.y - area.top);
  };

  const ImGuiIO& io = ImGui::GetIO();
  const float reach = 5 * pixel_ratio;
  const glm::vec2 place = place_of(io.MousePos), begin = place_of(io.MouseClickedPos[0]);

  // The point under the mouse.
  const bool down = ImGui::IsMouseDown(ImGuiMouseButton_Left);
  if (!down) {
    if (const auto point = point_under(shown, place, reach))
      draw_footer(text_of(*point, shown.frame), area);
  }

  if (!state.measures) return;

  // A drag selects a rectangle, a click an end of a distance.
  const bool dragged = glm::distance(place, begin) > reach;
  if (down && dragged) draw_rectangle(io.MouseClickedPos[0], io.MousePos);

  // A drag that starts in the panel does not act on the cloud.
  if (!ImGui::IsMouseReleased(ImGuiMouseButton_Left) || io.MouseDownOwned[0]) return;

  if (dragged) {
    fit_shapes(state.measured, points_between(shown, begin, place), shown.frame);
  } else if (const auto point = point_under(shown, place, reach)) {
    add_end(state.measured, *point, shown.frame);
  }
}

}  // namespace slipstream::view
