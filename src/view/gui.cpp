#include "view/gui.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include "io/plot.h"
#include "slipstream/error.h"
#include "view/opengl.h"
#include "view/scene_renderer.h"

namespace slipstream::view {
namespace {

/// From Debian's fonts-dejavu-core; otherwise Dear ImGui's built-in font is used.
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

constexpr ImU32 ink = IM_COL32(226, 230, 236, 255), field = IM_COL32(19, 21, 25, 225),
                marked = IM_COL32(255, 205, 80, 255);

/// Text of that size at a place, on a dark field; `wrap` 0: in one line.
void draw_words(const std::string& words, const ImVec2& size, float wrap, const ImVec2& at,
                float margin, float rounding) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddRectFilled({at.x - margin, at.y - margin},
                     {at.x + size.x + margin, at.y + size.y + margin}, field, rounding);
  list.AddText(ImGui::GetFont(), ImGui::GetFontSize(), at, ink, words.c_str(), nullptr, wrap);
}

}  // namespace

float Screen::pixel_ratio() const {
  return window.width > 0 ? static_cast<float>(framebuffer.width) / static_cast<float>(window.width)
                          : 1;
}

float Screen::unit() const {
  // Up to about this window size text is as large as elsewhere on the desktop.
  constexpr float ordinary_width = 1600, ordinary_height = 960;

  const float share = std::min(static_cast<float>(window.width) / ordinary_width,
                               static_cast<float>(window.height) / ordinary_height);
  return std::max({content_scale / pixel_ratio(), share, 0.5F});
}

Screen screen_of(const opengl::Window& window) {
  Screen screen{.framebuffer = window.framebuffer_size()};
  float across = 0, down = 0;

  glfwGetWindowSize(window.get(), &screen.window.width, &screen.window.height);
  glfwGetWindowContentScale(window.get(), &across, &down);

  if (across > 0) screen.content_scale = across;
  return screen;
}

Gui::Gui(const opengl::Window* window) : has_window_(window != nullptr) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // writes no settings file into the working directory

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

  // The font is made at the size in which it is drawn, so that it stays sharp.
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
#if IMGUI_VERSION_NUM < 19200  // later ones do this themselves
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
#endif
}

void Gui::begin_frame(const Screen& screen) {
  ImGui_ImplOpenGL3_NewFrame();
  set_scale(screen);

  ImGuiIO& io = ImGui::GetIO();
  if (has_window_) {
    ImGui_ImplGlfw_NewFrame();
  } else {
    io.DeltaTime = 1.0F / 60;
  }

  // Not as GLFW has just told: if the desktop has ended since, that is no size.
  io.DisplaySize = {static_cast<float>(screen.window.width),
                    static_cast<float>(screen.window.height)};
  io.DisplayFramebufferScale = {screen.pixel_ratio(), screen.pixel_ratio()};

  ImGui::NewFrame();
}

void Gui::end_frame() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void draw_depth_scale(const Range& depths, const Area& area, float unit) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();

  // 1. The scale's place, in the lower right corner.
  const float width = 14 * unit, text = ImGui::GetFontSize();
  const float height = std::min(220 * unit, 0.5F * area.height);
  const float left = area.left + area.width - width - 62 * unit;
  const float bottom = area.top + area.height - 20 * unit, top = bottom - height;

  const ColourMap colours = depth_colours();
  const float step = height / static_cast<float>(colours.size());

  // 2. A dark field, and the colours from near to far.
  list.AddRectFilled({left - 10 * unit, top - text - 14 * unit},
                     {left + width + 58 * unit, bottom + 12 * unit}, field, 4 * unit);
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const float y = top + step * static_cast<float>(i);
    const auto [red, green, blue] = colours[i];
    list.AddRectFilled({left, y}, {left + width, y + step + 0.5F}, IM_COL32(red, green, blue, 255));
  }

  // 3. The title, and marks at round depths.
  list.AddText({left, top - text - 6 * unit}, ink, "depth, mm");
  for (const double mark : marks_between(depths.low, depths.high, 6)) {
    const float share = (static_cast<float>(mark) - depths.low) / (depths.high - depths.low);

    const float y = top + share * height;
    list.AddLine({left + width, y}, {left + width + 5 * unit, y}, ink, unit);
    list.AddText({left + width + 8 * unit, y - 0.5F * text}, ink,
                 fmt::format("{:g}", mark).c_str());
  }
}

void draw_note(const std::string& words, const Area& area, float unit) {
  const float wrap = std::min(0.85F * area.width, 520 * unit);

  const ImVec2 size = ImGui::CalcTextSize(words.c_str(), nullptr, false, wrap);

  draw_words(words, size, wrap,
             {area.left + 0.5F * (area.width - size.x), area.top + 0.5F * (area.height - size.y)},
             14 * unit, 6 * unit);
}

void draw_footer(const std::string& words, const Area& area) {
  const ImVec2 size = ImGui::CalcTextSize(words.c_str());
  const float margin = 0.5F * ImGui::GetFontSize();
  draw_words(words, size, 0, {area.left + 2 * margin, area.top + area.height - size.y - 2 * margin},
             margin, margin);
}

void draw_rectangle(const ImVec2& corner, const ImVec2& opposite) {
  ImGui::GetBackgroundDrawList()->AddRect(
      {std::min(corner.x, opposite.x), std::min(corner.y, opposite.y)},
      {std::max(corner.x, opposite.x), std::max(corner.y, opposite.y)}, marked, 0, 0, 2);
}

void draw_ends(const std::vector<MeasuredPoint>& ends, const glm::mat4& clip, const Area& area,
               float unit) {
  const Size picture{static_cast<int>(area.width), static_cast<int>(area.height)};
  ImDrawList& list = *ImGui::GetBackgroundDrawList();

  std::vector<ImVec2> places;
  for (const MeasuredPoint& end : ends) {
    const glm::vec4 point(end.position.x(), end.position.y(), end.position.z(), 1);
    const auto place = pixel_of(clip * point, picture);
    if (!place) continue;

    places.emplace_back(area.left + place->x, area.top + place->y);
    list.AddCircle(places.back(), 6 * unit, marked, 0, 2 * unit);
  }

  if (places.size() == 2) list.AddLine(places[0], places[1], marked, 2 * unit);
}

void draw_guide(const Guide& guide, const opengl::PictureTexture& picture, const Area& area) {
  // Text is larger than elsewhere, and grows with the window.
  const float size = std::max(1.2F * ImGui::GetFontSize(), area.height / 40);
  const float margin = 0.5F * size, wrap = area.width - 2 * margin;

  std::vector<std::pair<const std::string*, float>> texts{{&guide.headline, 1.5F * size}};
  for (const std::string& line : guide.lines) texts.emplace_back(&line, size);
  const auto height_of = [&](const std::string& text, float font) {
    return margin / 2 + ImGui::GetFont()->CalcTextSizeA(font, wrap, wrap, text.c_str()).y;
  };

  // The picture takes the room that the texts leave.
  float height = area.height - margin;
  for (const auto& [text, font] : texts) height -= height_of(*text, font);
  draw_picture(picture, {area.left, area.top, area.width, height});

  // The texts below it, line by line.
  float y = area.top + height;
  const auto [red, green, blue] = guide.colour;
  for (const auto& [text, font] : texts) {
    const ImU32 colour = text == &guide.headline ? IM_COL32(red, green, blue, 255) : ink;
    ImGui::GetBackgroundDrawList()->AddText(ImGui::GetFont(), font, {area.left + margin, y}, colour,
                                            text->c_str(), nullptr, wrap);
    y += height_of(*text, font);
  }
}

void draw_picture(const opengl::PictureTexture& picture, const Area& area) {
  const auto width = static_cast<float>(picture.size().width);
  const auto height = static_cast<float>(picture.size().height);

  if (width < 1 || height < 1) return;

  const float scale = std::min(area.width / width, area.height / height);
  const ImVec2 at(area.left + 0.5F * (area.width - scale * width),
                  area.top + 0.5F * (area.height - scale * height));

  ImGui::GetBackgroundDrawList()->AddImage(
      std::bit_cast<ImTextureID>(std::uintptr_t{picture.number()}), at,
      {at.x + scale * width, at.y + scale * height});
}

}  // namespace slipstream::view
