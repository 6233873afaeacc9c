#include "slipstream/view/guide_window.h"

#include <algorithm>
#include <utility>

#include <GLFW/glfw3.h>
#include <epoxy/gl.h>
#include <imgui.h>

#include "slipstream/view/gui.h"
#include "slipstream/view/opengl.h"
#include "slipstream/view/window.h"

namespace slipstream::view {
namespace {

/// Text is as large as in a window of that height.
constexpr float usual_height = 640;

Screen readable(Screen screen) {
  const float grown = static_cast<float>(screen.framebuffer.height) / usual_height;
  screen.content_scale = std::max(screen.content_scale, grown);
  return screen;
}

void draw_text(const Guide& guide) {
  const auto part = [](std::uint8_t value) { return static_cast<float>(value) / 255; };
  ImGui::SetWindowFontScale(1.5F);
  ImGui::PushStyleColor(ImGuiCol_Text, {part(guide.colour.red), part(guide.colour.green),
                                        part(guide.colour.blue), 1});
  ImGui::TextWrapped("%s", guide.headline.c_str());
  ImGui::PopStyleColor();
  ImGui::SetWindowFontScale(1);
  for (const std::string& line : guide.lines) ImGui::TextWrapped("%s", line.c_str());
}

/// Whole window: the picture, and below it room for two lines of the headline and all others.
void draw(const Guide& guide, const opengl::PictureTexture& texture, const Screen& screen) {
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize(
      {static_cast<float>(screen.window.width), static_cast<float>(screen.window.height)});
  ImGui::Begin("guide", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoBackground |
                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  const float lines = 3 + static_cast<float>(guide.lines.size());
  const ImVec2 at = ImGui::GetCursorPos(), room = ImGui::GetContentRegionAvail();
  const float height = room.y - lines * ImGui::GetTextLineHeightWithSpacing();
  draw_picture(texture, {at.x, at.y, room.x, height});
  ImGui::SetCursorPosY(at.y + height);
  draw_text(guide);
  ImGui::End();
}

}  // namespace

struct GuideWindow::Parts {
  Parts(const opengl::WindowSystem& system, const opengl::WindowSettings& settings)
      : window(system, settings), gui(&window) {}

  void draw_last() {
    window.make_current();
    const Screen screen = readable(screen_of(window));
    glViewport(0, 0, screen.framebuffer.width, screen.framebuffer.height);
    glClear(GL_COLOR_BUFFER_BIT);
    gui.begin_frame(screen);
    draw(last, texture, screen);
    gui.end_frame();
  }

  opengl::Window window;
  Gui gui;
  opengl::PictureTexture texture;
  Guide last;
};

GuideWindow::GuideWindow(const opengl::WindowSystem& system, const std::string& title, Size size)
    : parts_(
          std::make_unique<Parts>(system, opengl::WindowSettings{.title = title, .size = size})) {}

GuideWindow::~GuideWindow() {
  parts_->window.make_current();
}

void GuideWindow::show(Guide guide) {
  parts_->window.make_current();
  parts_->texture.upload(guide.picture);
  parts_->last = std::move(guide);
  parts_->draw_last();
  parts_->window.swap();
}

bool GuideWindow::closed() const {
  glfwPollEvents();
  return parts_->window.should_close() ||
         glfwGetKey(parts_->window.get(), GLFW_KEY_ESCAPE) == GLFW_PRESS;
}

Image<Colour> GuideWindow::picture() const {
  parts_->draw_last();
  return opengl::read_pixels(parts_->window.framebuffer_size());
}

}  // namespace slipstream::view
