#include "slipstream/view/gui.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "slipstream/base/error.h"

namespace slipstream::view {
namespace {

/// Of Debian's fonts-dejavu-core; where it is not there the font within Dear ImGui does.
constexpr const char* font_file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr float font_size = 14;

ImGuiStyle style_at(float unit) {
  ImGuiStyle style;
  ImGui::StyleColorsDark(&style);
  style.WindowRounding = 0;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.WindowBorderSize = 0;
  style.WindowPadding = {12, 10};
  style.ItemSpacing = {8, 5};
  style.Colors[ImGuiCol_WindowBg] = {0.075F, 0.082F, 0.098F, 0.97F};
  style.Colors[ImGuiCol_Header] = {0.17F, 0.20F, 0.26F, 1};
  style.ScaleAllSizes(unit);
  return style;
}

}  // namespace

float Screen::pixel_ratio() const {
  return window.width > 0 ? static_cast<float>(framebuffer.width) / static_cast<float>(window.width)
                          : 1;
}

float Screen::unit() const {
  // Up to about this size text is as large as elsewhere on the desktop.
  constexpr float ordinary_width = 1600, ordinary_height = 960;
  const float share = std::min(static_cast<float>(window.width) / ordinary_width,
                               static_cast<float>(window.height) / ordinary_height);
  return std::max({content_scale / pixel_ratio(), share, 0.5F});
}

Screen screen_of(const opengl::Window& window) {
  return {window.size(), window.framebuffer_size(), window.content_scale()};
}

Gui::Gui(const opengl::Window* window) : has_window_(window != nullptr) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // nothing is written where the program happens to run
  const bool window_ready = !has_window_ || ImGui_ImplGlfw_InitForOpenGL(window->get(), true);
  if (!window_ready || !ImGui_ImplOpenGL3_Init("#version 330 core")) {
    ImGui::DestroyContext();
    throw WorldError("Dear ImGui does not start on this OpenGL");
  }
}

Gui::~Gui() {
  ImGui_ImplOpenGL3_Shutdown();
  if (has_window_) ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void Gui::set_scale(const Screen& screen) {
  ImGuiIO& io = ImGui::GetIO();
  io.FontGlobalScale = 1 / screen.pixel_ratio();
  if (screen.unit() != unit_) {
    unit_ = screen.unit();
    ImGui::GetStyle() = style_at(unit_);
  }
  const float pixels = std::round(font_size * screen.unit() * screen.pixel_ratio());
  if (pixels == font_pixels_) return;
  font_pixels_ = pixels;
  io.Fonts->Clear();
  if (std::filesystem::exists(font_file)) {
    io.Fonts->AddFontFromFileTTF(font_file, pixels);
  } else {
    ImFontConfig font;
    font.SizePixels = pixels;
    io.Fonts->AddFontDefault(&font);
  }
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
}

void Gui::begin_frame(const Screen& screen) {
  ImGui_ImplOpenGL3_NewFrame();
  set_scale(screen);
  if (has_window_) {
    ImGui_ImplGlfw_NewFrame();
  } else {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {static_cast<float>(screen.window.width),
                      static_cast<float>(screen.window.height)};
    io.DisplayFramebufferScale = {screen.pixel_ratio(), screen.pixel_ratio()};
    io.DeltaTime = 1.0F / 60;
  }
  ImGui::NewFrame();
}

void Gui::end_frame() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace slipstream::view
