#include "slipstream/view/cloud_screen.h"

#include <algorithm>
#include <cmath>
#include <exception>

#include <GLFW/glfw3.h>
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <imgui.h>

#include "slipstream/view/axes.h"
#include "slipstream/view/pictures.h"

namespace slipstream::view {
namespace {

constexpr int picture_width = 480;

PointImages images_of(const Cloud& cloud) {
  return {cloud.x, cloud.y, cloud.z, cloud.intensity};
}

/// The part of the framebuffer between panel and pictures.
Pane pane_between(const PanelWidths& widths, const Screen& screen) {
  const auto pixels = [&](float units) {
    return static_cast<int>(std::lround(units * screen.pixel_ratio()));
  };
  const int left = pixels(widths.left);
  return {.left = left,
          .size = {std::max(screen.framebuffer.width - left - pixels(widths.right), 1),
                   std::max(screen.framebuffer.height, 1)}};
}

/// With room under it for the beginning of its reflection.
Box with_reflection(Box box, bool reflected) {
  if (reflected) box.high.y += 0.12F * (box.high.y - box.low.y);
  return box;
}

}  // namespace

CloudScreen::CloudScreen(const ViewSource& source, const ViewSettings& settings,
                         const opengl::Window* window)
    : source_(source), gui_(window), counted_since_(std::chrono::steady_clock::now()) {
  state_.view = settings;
  if (!source.setup) return;
  state_.setup = *source.setup;
  engine_.emplace(*source.setup);
}

bool CloudScreen::take_newest() {
  if (state_.paused) return false;
  ShownCloud newest = source_.newest();
  if (!newest || newest.is(cloud_)) return false;
  cloud_ = std::move(newest);
  told_shown_ = false;
  set_cloud(cloud_);
  return true;
}

const Maps* CloudScreen::maps_of(const FrameViews& frames) {
  if (!engine_ || frames.count() != frame_count(engine_->setup().sequence)) return nullptr;
  engine_->maps(frames, maps_);
  return &maps_;
}

void CloudScreen::set_cloud(const ShownCloud& shown) {
  state_.points = point_count(*shown.cloud);
  state_.pixels = shown.cloud->z.pixel_count();
  const bool pictures = state_.shown && (state_.picture_open[1] || state_.picture_open[2]);
  const bool wanted = pictures || state_.view.colour == PointColour::modulation;
  const Maps* const maps = wanted ? maps_of(shown.frames) : nullptr;
  scene_.set_cloud(images_of(*shown.cloud), maps != nullptr ? &maps->modulation : nullptr,
                   state_.view.colour);
  if (state_.shown) update_pictures(shown.frames, maps);
  drawn_colour_ = state_.view.colour;
  drawn_open_ = state_.picture_open;
  // The first clouds may be of an empty room.
  if (!fitted_ && state_.points > state_.pixels / 50) fit_wanted_ = true;
}

void CloudScreen::update_pictures(const FrameViews& frames, const Maps* maps) {
  if (state_.picture_open[0] && frames.count() != 0) {
    pictures_[0].upload(camera_picture(frames, picture_width));
  }
  if (maps == nullptr) return;
  if (state_.picture_open[1]) {
    pictures_[1].upload(modulation_picture(maps->modulation, picture_width));
  }
  if (state_.picture_open[2]) {
    const auto least =
        static_cast<float>(least_modulation(state_.setup.settings, frames.full_scale()));
    pictures_[2].upload(phase_picture(maps->wrapped_phase, maps->modulation, least, picture_width));
  }
}

void CloudScreen::draw(const Screen& screen) {
  const bool other_look = drawn_colour_ != state_.view.colour || drawn_open_ != state_.picture_open;
  if (cloud_ && other_look) set_cloud(cloud_);
  const Pane pane = pane_between(panel_widths(state_, source_, screen), screen);
  if (cloud_ && fit_wanted_) {
    scene_.set_extent(extent_of(images_of(*cloud_.cloud)));
    state_.view.camera =
        fitted(state_.view.camera, with_reflection(scene_.extent().box, state_.view.reflection),
               pane.size);
    fitted_ = true;
    fit_wanted_ = false;
  }
  state_.grid_mm = grid_step(scene_.extent().box);
  const double ambient = engine_ ? engine_->setup().scanner.photometry.ambient.value_or(0.0) : 0.0;
  scene_.draw(state_.view, ambient, pane, screen.unit() * screen.pixel_ratio());

  glViewport(0, 0, screen.framebuffer.width, screen.framebuffer.height);
  PanelRequests requests;
  gui_.begin_frame(screen);
  hear_of_saving();
  const LiveStatistics statistics = source_.statistics ? source_.statistics() : LiveStatistics{};
  draw_panel(state_, requests, source_, statistics, screen);
  draw_pictures(state_, pictures_, source_, screen);
  move_camera(pane, screen);
  take_keys(requests);
  gui_.end_frame();
  answer(requests);
  count_drawn();
}

void CloudScreen::move_camera(const Pane& pane, const Screen& screen) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantCaptureMouse) return;
  const float height = static_cast<float>(pane.size.height) / screen.pixel_ratio();
  const glm::vec2 drag(io.MouseDelta.x / height, io.MouseDelta.y / height);
  OrbitCamera& camera = state_.view.camera;
  if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
    camera = io.KeyShift ? panned(camera, drag) : orbited(camera, drag);
  } else if (ImGui::IsMouseDown(ImGuiMouseButton_Right) ||
             ImGui::IsMouseDown(ImGuiMouseButton_Middle)) {
    camera = panned(camera, drag);
  }
  if (io.MouseWheel != 0) camera = zoomed(camera, io.MouseWheel);
}

void CloudScreen::take_keys(PanelRequests& requests) {
  if (ImGui::GetIO().WantTextInput) return;
  if (source_.statistics && ImGui::IsKeyPressed(GLFW_KEY_SPACE, false)) {
    state_.paused = !state_.paused;
  }
  if (ImGui::IsKeyPressed(GLFW_KEY_TAB, false)) state_.shown = !state_.shown;
  requests.fit |= ImGui::IsKeyPressed(GLFW_KEY_F, false);
  requests.save |= source_.save && ImGui::IsKeyPressed(GLFW_KEY_S, false);
  requests.toggle_recording |= source_.record && ImGui::IsKeyPressed(GLFW_KEY_R, false);
  const std::array<int, 3> colour_keys{GLFW_KEY_1, GLFW_KEY_2, GLFW_KEY_3};
  for (std::size_t i = 0; i < colour_keys.size(); ++i) {
    if (ImGui::IsKeyPressed(colour_keys[i], false)) {
      state_.view.colour = static_cast<PointColour>(i);
    }
  }
}

void CloudScreen::answer(const PanelRequests& requests) {
  if (requests.fit) fit_wanted_ = true;
  if (requests.change_setup) change_setup();
  if (requests.save) save();
  if (requests.toggle_recording) {
    try {
      source_.record(!source_.recording || source_.recording().empty());
      state_.message.clear();
    } catch (const std::exception& error) {
      state_.message = error.what();
    }
  }
}

void CloudScreen::change_setup() {
  try {
    Engine engine(state_.setup);
    source_.change(state_.setup);
    engine_ = std::move(engine);
    accepted_strategy_ = state_.strategy;
    accepted_gamma_ = state_.gamma;
    state_.message.clear();
  } catch (const std::exception& error) {
    state_.message = error.what();
    state_.setup = engine_->setup();
    state_.strategy = accepted_strategy_;
    state_.gamma = accepted_gamma_;
  }
}

void CloudScreen::save() {
  if (!cloud_ || !engine_ || saving_.valid()) return;
  state_.message = "saving ...";
  saving_ =
      std::async(std::launch::async, [save = source_.save, cloud = cloud_,
                                      setup = engine_->setup()] { return save(cloud, setup); });
}

void CloudScreen::hear_of_saving() {
  if (!saving_.valid()) return;
  if (saving_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  try {
    state_.message = fmt::format("saved: {}", saving_.get());
  } catch (const std::exception& error) {
    state_.message = fmt::format("not saved: {}", error.what());
  }
}

void CloudScreen::tell_shown() {
  if (!cloud_ || told_shown_) return;
  told_shown_ = true;
  if (source_.shown) source_.shown(cloud_);
}

void CloudScreen::count_drawn() {
  ++counted_;
  const auto now = std::chrono::steady_clock::now();
  const std::chrono::duration<double> seconds = now - counted_since_;
  if (seconds.count() < 1) return;
  state_.drawn_per_second = counted_ / seconds.count();
  counted_ = 0;
  counted_since_ = now;
}

}  // namespace slipstream::view
