#include "view/cloud_screen.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <optional>
#include <string>

#include <GLFW/glfw3.h>
#include <epoxy/gl.h>
#include <imgui.h>

#include "reconstruct/engine_setup.h"
#include "view/gui.h"
#include "view/lines.h"
#include "view/measuring.h"
#include "view/mouse.h"
#include "view/opengl.h"
#include "view/orbit_camera.h"
#include "view/panel.h"
#include "view/pictures.h"
#include "view/scene_renderer.h"
#include "view/timeline.h"

namespace slipstream::view {
namespace {

constexpr int picture_width = 480, large_picture_width = 1920;

PointImages images_of(const Cloud& cloud) {
  return {cloud.x, cloud.y, cloud.z, cloud.intensity, nullptr, &cloud.colour};
}

/// Closes menus or the list of keys; without any, asks whether to close the window, or takes that
/// back.
void escape(PanelState& state) {
  constexpr auto any = ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel;

  if (ImGui::IsPopupOpen("", any)) {
    ImGui::SetWindowFocus(nullptr);  // closes menus and drop-down lists
  } else if (state.shows_keys) {
    state.shows_keys = false;
  } else {
    state.closing = !state.closing;
  }
}

/// The part of the framebuffer between panel and pictures.
Pane pane_between(const PanelMargins& margins, const Screen& screen) {
  const auto pixels = [&](float units) {
    return static_cast<int>(std::lround(units * screen.pixel_ratio()));
  };

  const int left = pixels(margins.left);
  return {.left = left,
          .size = {std::max(screen.framebuffer.width - left - pixels(margins.right), 1),
                   std::max(screen.framebuffer.height - pixels(margins.top), 1)}};
}

}  // namespace

CloudScreen::CloudScreen(const ViewSource& source, const ViewSettings& settings,
                         const opengl::Window* window)
    : source_(source), gui_(window), counted_since_(std::chrono::steady_clock::now()) {
  state_.view = settings;
  ask_camera();

  if (source.openable) state_.openable = source.openable();

  // The axes of another frame, as seen by the scanner.
  if (source.frame) {
    const Eigen::Matrix3f turn = source.frame->transform.linear().cast<float>();
    glm::mat3 directions;
    for (int axis = 0; axis < 3; ++axis) {
      directions[axis] = {turn(axis, 0), turn(axis, 1), turn(axis, 2)};
    }
    scene_.set_axes(directions);
  }

  if (!source.setup) return;
  state_.setup = *source.setup;
  engine_.emplace(*source.setup);
}

bool CloudScreen::take_newest() {
  if (state_.paused) return false;
  play();

  ShownCloud newest = source_.newest();
  if (!newest || newest.is(cloud_)) return false;

  cloud_ = std::move(newest);
  state_.findings = cloud_.findings;
  told_shown_ = false;
  uncertainty_.reset();

  set_cloud();
  expose();
  return true;
}

const Maps* CloudScreen::maps_of(const FrameViews& frames) {
  if (!engine_ || frames.count() != frame_count(engine_->setup().sequence)) return nullptr;
  // A change of strategy waits for the first cloud of the new patterns.
  if (cloud_.sequence && *cloud_.sequence != engine_->setup().sequence) return nullptr;

  const FrameViews& merged = engine_->merged(frames);
  engine_->maps(merged, maps_);
  maps_full_scale_ = merged.full_scale();
  return &maps_;
}

void CloudScreen::set_cloud() {
  drawn_ = look();
  if (pictures_alone(source_)) return set_pictures();

  // 1. Counts for the panel.
  const Cloud& cloud = *cloud_.cloud;
  state_.counts = count_by_validity(cloud);
  state_.pixels = cloud.z.pixel_count();

  // 2. Maps only if something shows them: decoding takes time.
  const bool pictures = state_.shown && (state_.picture_open[1] || state_.picture_open[2]);
  const bool wanted = pictures || state_.view.colour == PointColour::modulation;
  const Maps* const maps = wanted ? maps_of(cloud_.frames) : nullptr;

  // 3. Upload the cloud and the pictures.
  PointImages images = images_of(cloud);
  if (state_.view.shaded) shading_ = shading(cloud);
  images.shading = state_.view.shaded ? &shading_ : nullptr;
  scene_.set_cloud(images, maps != nullptr ? &maps->modulation : nullptr, state_.view.colour);
  if (state_.shown) update_pictures(cloud_.frames, maps);

  // The first clouds may show an empty room.
  if (!fitted_ && point_count(cloud) > state_.pixels / 50) fit_wanted_ = true;
}

void CloudScreen::set_pictures() {
  const Maps* const maps = maps_of(cloud_.frames);
  if (maps == nullptr) return;

  PictureReport report =
      picture_report(engine_->merged(cloud_.frames), *maps, engine_->setup().settings);

  validity_ = std::move(report.validity);
  state_.counts = count_by_validity(validity_);
  state_.pixels = validity_.pixel_count();
  state_.modulation = report.modulation;

  update_pictures(cloud_.frames, maps);
}

int CloudScreen::width_of(std::size_t picture) const {
  const bool large = pictures_alone(source_) && picture == state_.picture;
  return large ? large_picture_width : picture_width;
}

void CloudScreen::update_pictures(const FrameViews& frames, const Maps* maps) {
  const auto wanted = [&](std::size_t picture) {
    return state_.picture_open[picture] || width_of(picture) == large_picture_width;
  };

  if (wanted(0) && frames.count() != 0) {
    const bool known = validity_.size() == frames.size();
    pictures_[0].upload(camera_picture(frames, width_of(0), known ? &validity_ : nullptr));
    state_.histogram = grey_histogram(frames);
  }

  // The other pictures need the frames' maps.
  if (maps == nullptr) return;
  if (wanted(1)) pictures_[1].upload(modulation_picture(maps->modulation, width_of(1)));
  if (wanted(2)) {
    const auto least =
        static_cast<float>(least_modulation(state_.setup.settings, maps_full_scale_));
    pictures_[2].upload(phase_picture(maps->wrapped_phase, maps->modulation, least, width_of(2)));
  }
}

void CloudScreen::draw_scene(const Pane& pane, const Screen& screen) {
  if (cloud_ && fit_wanted_) {
    scene_.set_extent(extent_of(images_of(*cloud_.cloud)));
    Box box = scene_.extent().box;

    // Leaves room below for the start of the reflection.
    if (state_.view.reflection) box.high.y += 0.12F * (box.high.y - box.low.y);
    state_.view.camera = fitted(state_.view.camera, box, pane.size);

    fitted_ = true;
    fit_wanted_ = false;
  }

  state_.grid_mm = grid_step(scene_.extent().box);

  ViewSettings settings = state_.view;
  // Without points there is nothing to place them by.
  if (state_.counts.front() == 0) settings.axes = settings.grid = false;

  const double ambient = engine_ ? engine_->setup().scanner.photometry.ambient.value_or(0.0) : 0.0;
  scene_.draw(settings, ambient, pane, screen.unit() * screen.pixel_ratio());
  glViewport(0, 0, screen.framebuffer.width, screen.framebuffer.height);
}

void CloudScreen::draw_over(const Area& area, const Screen& screen) const {
  if (beginning_ != nullptr) return draw_note(beginning_->name + " ...", area, screen.unit());
  if (source_.guide) return draw_guide(guide_, guide_picture_, area);
  if (!cloud_) return draw_note(source_.waits_for, area, screen.unit());
  if (pictures_alone(source_)) return draw_picture(pictures_.at(state_.picture), area);
  const std::string why = why_no_points(state_);
  if (!why.empty()) return draw_note(why, area, screen.unit());
  if (scene_.shows_depths(state_.view.colour)) {
    draw_depth_scale(scene_.depths(), area, screen.unit());
  }
}

void CloudScreen::draw(const Screen& screen) {
  if (cloud_ && drawn_ != look()) set_cloud();

  // 1. The cloud, between panel and pictures.
  const PanelMargins margins = panel_margins(state_, source_, screen);
  const Pane pane = pane_between(margins, screen);
  draw_scene(pane, screen);

  // 2. News since the last picture.
  PanelRequests requests;
  gui_.begin_frame(screen);
  hear_of_saving();
  hear_of_dialog();
  hear_of_changes();
  if (auto newest = source_.guide ? source_.guide() : std::nullopt) {
    guide_ = *std::move(newest);
    guide_picture_.upload(guide_.picture);
  }

  // 3. Texts over the cloud, the panel and the pictures.
  const LiveStatistics statistics = source_.statistics ? source_.statistics() : LiveStatistics{};
  const auto width = static_cast<float>(screen.window.width) - margins.left - margins.right;
  const auto height = static_cast<float>(screen.window.height) - margins.top;
  const Area area{margins.left, margins.top, std::max(width, 1.0F), std::max(height, 1.0F)};
  state_.can_undo = !earlier_.empty();
  draw_over(above_timeline(area), screen);
  draw_timeline(state_, requests, source_, area);
  draw_panel(state_, requests, source_, statistics, screen);
  draw_pictures(state_, pictures_, source_, screen);

  // 4. Mouse and keys.
  take_mouse(pane, area, screen);
  for (const int key : std::exchange(keys_, {})) {
    // Keys typed into a text field go to the field.
    if (!ImGui::GetIO().WantTextInput) take_key(key, requests);
  }

  gui_.end_frame();

  // 5. Act on the requests.
  if (beginning_ != nullptr) next_ = beginning_->begin;
  answer(requests);
  count_drawn();
}

Area CloudScreen::above_timeline(Area area) const {
  area.height -= timeline_height(state_, source_);
  return area;
}

void CloudScreen::take_mouse(const Pane& pane, const Area& area, const Screen& screen) {
  if (pictures_alone(source_) || state_.view.three_views) return;

  const OrbitCamera& camera = state_.view.camera;

  if (!ImGui::GetIO().WantCaptureMouse) {
    move_camera(state_, pane, screen);
    if (cloud_ && ImGui::IsMousePosValid()) {
      measure(state_,
              {*cloud_.cloud, uncertainty(), clip_matrix(camera, pane.size), pane.size,
               source_.frame.get()},
              above_timeline(area), screen.pixel_ratio());
    }
  }

  if (state_.measures) {
    draw_ends(state_.measured.ends, clip_matrix(camera, pane.size), area, screen.unit());
  }
}

const Uncertainty* CloudScreen::uncertainty() {
  if (cloud_.uncertainty) return cloud_.uncertainty.get();

  // Computed only for a cloud that stays, since it takes long.
  const bool stands_still = !source_.statistics || state_.paused;
  const bool noise_known = engine_ && engine_->setup().scanner.photometry.noise_variance;
  const bool is_of_frames = cloud_.cloud->size() == cloud_.frames.size();
  if (!uncertainty_ && stands_still && noise_known && is_of_frames) {
    const Maps* const maps = maps_of(cloud_.frames);
    if (maps != nullptr) uncertainty_ = engine_->uncertainty(*cloud_.cloud, *maps, cloud_.frames);
  }

  return uncertainty_ ? &*uncertainty_ : nullptr;
}

void CloudScreen::take_key(int key, PanelRequests& requests) {
  if (key == GLFW_KEY_ESCAPE) escape(state_);
  const bool is_enter = key == GLFW_KEY_ENTER || key == GLFW_KEY_KP_ENTER;
  if (is_enter && state_.closing) requests.close = true;
  if (key == GLFW_KEY_SPACE && source_.statistics) state_.paused = !state_.paused;
  if (key == GLFW_KEY_SPACE && source_.scans > 1) state_.plays = !state_.plays;
  if (key == GLFW_KEY_LEFT || key == GLFW_KEY_RIGHT) {
    const std::size_t scan = requests.scan.value_or(state_.scan);
    requests.scan = scan_after(scan, source_, key == GLFW_KEY_LEFT ? -1 : 1);
  }
  if (key == GLFW_KEY_Z) requests.undo = true;
  if (key == GLFW_KEY_TAB) state_.shown = !state_.shown;
  if (key == GLFW_KEY_F) requests.fit = true;

  if (source_.steps) {
    for (const ViewStep& step : source_.steps->buttons) {
      if (step.key == key) requests.step = &step;
    }
  }

  if (key == GLFW_KEY_E && can_choose_exposure(state_, source_)) requests.expose = true;
  if (key == GLFW_KEY_M) state_.measures = !state_.measures;
  if (key == GLFW_KEY_S && source_.save) requests.save = true;
  if (key == GLFW_KEY_O && source_.open) {
    requests.file = {FileQuestion::open, state_.path.data()};
  }
  if (key == GLFW_KEY_R && source_.record) requests.toggle_recording ^= true;
  if (key == GLFW_KEY_G && source_.check_rig) requests.check_rig = true;

  if (key >= GLFW_KEY_1 && key <= GLFW_KEY_3) {
    state_.view.colour = static_cast<PointColour>(key - GLFW_KEY_1);
    state_.picture = static_cast<std::size_t>(key - GLFW_KEY_1);
  }

  if (key == GLFW_KEY_8) state_.view.colour = PointColour::camera;

  if (key >= GLFW_KEY_4 && key <= GLFW_KEY_6) {
    requests.viewpoint = static_cast<Viewpoint>(key - GLFW_KEY_4);
  }

  if (key == GLFW_KEY_7) state_.view.three_views = !state_.view.three_views;
}

void CloudScreen::answer(const PanelRequests& requests) {
  if (requests.viewpoint) {
    state_.view.camera = looking_from(state_.view.camera, *requests.viewpoint);
    state_.view.three_views = false;
  }

  if (requests.fit || requests.viewpoint) fit_wanted_ = true;

  if (const auto& asked = requests.set_control) {
    attempt([&] { source_.camera->set_control(asked->which, asked->value.value); });
    ask_camera();
  }

  if (requests.close) closed_ = true;
  if (requests.change_setup) change_setup();
  if (requests.undo) undo();
  if (requests.scan) {
    state_.plays = false;
    show_scan(*requests.scan);
  }
  if (requests.save) save();
  if (requests.file) take_file(*requests.file);
  if (requests.step != nullptr) beginning_ = requests.step;
  if (requests.expose) exposures_to_set_ = most_exposures;

  if (requests.toggle_recording) {
    attempt([&] { source_.record(!source_.recording || source_.recording().empty()); });
  }
  if (requests.check_rig) attempt(source_.check_rig);
}

bool CloudScreen::attempt(const std::function<void()>& action) try {
  action();

  state_.message.clear();
  return true;
} catch (const std::exception& error) {
  state_.message = source_.worded(error.what());
  return false;
}

void CloudScreen::show_scan(std::size_t number) {
  if (source_.scans < 2) return;
  scan_shown_at_ = std::chrono::steady_clock::now();
  state_.scan = number;
  attempt([&] { source_.show_scan(number); });
}

void CloudScreen::play() {
  const std::chrono::duration<double> shown = std::chrono::steady_clock::now() - scan_shown_at_;
  if (state_.plays && shown.count() >= source_.seconds_per_scan) {
    show_scan(scan_after(state_.scan, source_, 1));
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
