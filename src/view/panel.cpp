#include "view/panel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

#include "view/gui.h"
#include "view/menu.h"
#include "view/opengl.h"
#include "view/orbit_camera.h"
#include "view/speed.h"
#include "view/widgets.h"

namespace slipstream::view {
namespace {

#if IMGUI_VERSION_NUM < 18940  // their names then
constexpr auto& push_tab_stop = ImGui::PushAllowKeyboardFocus;
constexpr auto& pop_tab_stop = ImGui::PopAllowKeyboardFocus;
#else
constexpr auto& push_tab_stop = ImGui::PushTabStop;
constexpr auto& pop_tab_stop = ImGui::PopTabStop;
#endif

constexpr ImGuiWindowFlags fixed_window = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                          ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoTitleBar;

/// Problems and their causes, one short line each, without numbers.
void draw_findings(const std::vector<Finding>& findings, const ViewSource& source) {
  for (const Finding& finding : findings) {
    const ImVec4& colour = finding.severity == Severity::wrong ? bad : doubtful;
    const std::string symptom = source.worded(symptom_of(finding));
    const std::string causes = source.worded(causes_of(finding));
    say(colour, "{}{}{}", symptom, causes.empty() ? "" : ": ", causes);
  }
}

std::string percent_of(std::size_t count, std::size_t all) {
  const double percent =
      100 * static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(all, 1));
  return fmt::format("{:.{}f} %", percent, percent < 1 && count != 0 ? 2 : 1);
}

/// Pixel counts: points, and rejected pixels by reason.
void draw_counts(const PanelState& state, const ViewSource& source) {
  if (state.pixels == 0 || !section("Pixels")) return;

  const bool alone = pictures_alone(source);
  table("pixels", 2, ImGuiTableFlags_SizingFixedFit, [&] {
    ImGui::TableSetupColumn("share", ImGuiTableColumnFlags_WidthFixed,
                            ImGui::CalcTextSize("100.0 %").x);
    ImGui::TableSetupColumn("reason", ImGuiTableColumnFlags_WidthStretch);  // the reasons change
    for (std::size_t i = 0; i < state.counts.size(); ++i) {
      if (i != 0 && state.counts[i] == 0) continue;

      const std::string percent = percent_of(state.counts[i], state.pixels);
      const std::string_view reason = name_of(static_cast<Validity>(i));
      const std::string points = fmt::format("{} points", state.counts[i]);

      row(percent.c_str(), i != 0 ? std::string(reason) : alone ? "measured" : points);
    }
  });

  if (alone) say(quiet, "median modulation {:.0f} of 127 grey levels", state.modulation);
}

void draw_status(const PanelState& state, const ViewSource& source,
                 const LiveStatistics& statistics) {
  if (!statistics.source_state.empty()) say(bad, "{}", source.worded(statistics.source_state));

  draw_findings(state.findings, source);
  draw_findings(statistics.findings, source);

  if (statistics.track) say(white, "{}", text_of(*statistics.track));
  if (statistics.model) say(white, "{}", text_of(*statistics.model));

  draw_counts(state, source);
}

void draw_view_settings(PanelState& state, PanelRequests& requests) {
  if (!section("View")) return;

  // Colour and size of the points.
  ViewSettings& view = state.view;
  choose("colour", {"depth (1)", "reflectivity (2)", "modulation (3)", "camera (8)"}, view.colour);
  name_field("point size");
  ImGui::SliderFloat("##point size", &view.point_size, 0.3F, 6, "%.1f",
                     ImGuiSliderFlags_Logarithmic);
  if (view.colour != PointColour::depth) {
    name_field("contrast");
    ImGui::SliderFloat("##contrast", &view.brightness, 0.2F, 5, "%.2f",
                       ImGuiSliderFlags_Logarithmic);
  }

  // Further parts of the picture, in two columns.
  const float middle = 0.5F * ImGui::GetWindowWidth();
  ImGui::Checkbox("shading", &view.shaded);
  ImGui::SameLine(middle);
  ImGui::Checkbox("reflection", &view.reflection);
  ImGui::Checkbox("axes", &view.axes);
  ImGui::SameLine(middle);
  ImGui::Checkbox("floor", &view.grid);
  if (view.grid) say(quiet, "a line of the floor every {:g} mm", state.grid_mm);

  // The view.
  int viewpoint = 0;
  for (const char* const name : {"Front (4)", "Side (5)", "Top (6)"}) {
    if (ImGui::Button(name)) requests.viewpoint = static_cast<Viewpoint>(viewpoint);
    ++viewpoint;
    ImGui::SameLine();
  }

  requests.fit |= ImGui::Button("Fit (F)");
  ImGui::Checkbox("front, side and top (7)", &view.three_views);
}

void draw_measuring(PanelState& state) {
  if (!section("Measure")) return;

  ImGui::Checkbox("with the mouse (M)", &state.measures);
  if (state.measures && state.measured.lines.empty()) {
    say(quiet,
        "Click two points for their distance; drag over a surface for its plane and sphere.");
  }

  for (const std::string& line : state.measured.lines) say(white, "{}", line);
}

/// A list of files, and a field for any other path; if it is empty, a dialog asks.
void draw_files(PanelState& state, PanelRequests& requests, const ViewSource& source) {
  const bool can_save = has_points(state, source);
  if ((!source.open && !can_save) || !section("Files")) return;

  for (const std::string& name : state.openable) {
    if (ImGui::Selectable(name.c_str())) requests.file = {FileQuestion::open, name};
  }

  push_tab_stop(true);
  ImGui::SetNextItemWidth(-1);
  const char* const hint =
      source.open ? "path, then Enter; or drop a file here" : "path of the file to save";
  bool opens = ImGui::InputTextWithHint("##path", hint, state.path.data(), state.path.size(),
                                        ImGuiInputTextFlags_EnterReturnsTrue);
  pop_tab_stop();

  if (source.open) opens |= ImGui::Button("Open ... (O)");
  if (opens && source.open) requests.file = {FileQuestion::open, state.path.data()};
  if (!can_save) return;

  if (source.open) ImGui::SameLine();
  if (ImGui::Button("Save cloud as ...")) requests.file = {FileQuestion::save, state.path.data()};
  tell_help("the points as .ply, .pcd or .xyz, the surface as .stl, .obj or .glb");
}

/// Choices and buttons that lead to another source.
void draw_steps(PanelRequests& requests, const ViewSource& source) {
  if (!source.steps || !section("Scanner")) return;

  // The choices: a text field, or a drop-down of the options.
  for (ViewChoice& choice : source.steps->choices) {
    const std::string label = hidden_label(choice.name);
    name_field(choice.name.c_str());
    if (choice.options.empty()) {
      std::array<char, 1024> text{};
      choice.value.copy(text.data(), text.size() - 1);
      push_tab_stop(true);
      ImGui::InputTextWithHint(label.c_str(), choice.help.c_str(), text.data(), text.size());
      pop_tab_stop();
      choice.value = text.data();
    } else if (ImGui::BeginCombo(label.c_str(), choice.value.c_str())) {
      for (const std::string& option : choice.options) {
        if (ImGui::Selectable(option.c_str(), option == choice.value)) choice.value = option;
      }
      ImGui::EndCombo();
    }

    // A long value is cut off in its field.
    const bool may_be_cut = !choice.value.empty();
    tell_help((may_be_cut ? choice.value + "\n" + choice.help : choice.help).c_str());
  }

  // The buttons, side by side.
  for (const ViewStep& step : source.steps->buttons) {
    if (ImGui::Button(step.name.c_str())) requests.step = &step;
    tell_help(step.help.c_str());
    ImGui::SameLine();
  }
  ImGui::NewLine();

  if (!source.steps->message.empty()) say(doubtful, "{}", source.steps->message);
}

/// A filter and the number of points it removed.
bool draw_filter(const char* name, bool& on, const PanelState& state, Validity kind) {
  const std::size_t count = state.counts[static_cast<std::size_t>(kind)];

  const bool changed = ImGui::Checkbox(name, &on);
  ImGui::SameLine(0.62F * ImGui::GetWindowWidth());
  say(quiet, "{} points", count);
  return changed;
}

void draw_filters(PanelState& state, PanelRequests& requests, const ViewSource& source) {
  if (!source.setup || !source.change || !section("Cleaning")) return;

  const CleanSettings usual, off = CleanSettings::none(), &given = source.setup->settings.clean;
  CleanSettings& clean = state.setup.settings.clean;

  // A filter with a limit is on unless the limit is the one that turns it off.
  bool trusted = clean.largest_sigma != off.largest_sigma;
  bool connected = clean.smallest_component != off.smallest_component;
  bool changed = draw_filter("low trust", trusted, state, Validity::low_trust);
  changed |= draw_filter("mixed pixels", clean.drop_mixed, state, Validity::mixed);
  changed |= draw_filter("outliers", clean.drop_outliers, state, Validity::outlier);
  changed |= draw_filter("small components", connected, state, Validity::small_component);
  if (!changed) return;

  // Turned on again, a filter takes the source's limit, or the default if the source had it off.
  const auto limit = [&](bool wanted, auto CleanSettings::*of) {
    if (!wanted) return off.*of;
    return given.*of == off.*of ? usual.*of : given.*of;
  };

  clean.largest_sigma = limit(trusted, &CleanSettings::largest_sigma);
  clean.smallest_component = limit(connected, &CleanSettings::smallest_component);

  requests.change_setup = true;
}

void draw_scan_settings(PanelState& state, PanelRequests& requests, const ViewSource& source) {
  if (!source.setup || !source.change || !section("Scan")) return;

  ReconstructSettings& settings = state.setup.settings;
  if (choose_labelled("strategy", source.strategies, state.strategy)) {
    state.setup.sequence.strategy = source.strategies[state.strategy].second;
    requests.change_setup = true;
  }

  if (choose_labelled("gamma", source.gammas, state.gamma)) {
    state.setup.scanner.photometry.response = source.gammas[state.gamma].second;
    requests.change_setup = true;
  }

  auto threshold = static_cast<float>(settings.minimum_modulation);
  name_field("modulation from");
  if (ImGui::SliderFloat("##modulation from", &threshold, 1, 100, "%.0f of 127")) {
    settings.minimum_modulation = static_cast<double>(threshold);
  }

  // Every change rebuilds tables, so a dragged slider applies on release.
  requests.change_setup |= ImGui::IsItemDeactivatedAfterEdit();
  tell_help("minimum modulation of a valid pixel, grey levels of 255");

  requests.change_setup |= ImGui::Checkbox("reject saturated pixels", &settings.drop_saturated);
}

void draw_camera(PanelState& state, PanelRequests& requests, const ViewSource& source) {
  if (state.camera.empty() || !section("Camera")) return;

  for (ShownControl& shown : state.camera) {
    const CameraControlWords& words = camera_controls.at(static_cast<std::size_t>(shown.which));
    auto value = static_cast<float>(shown.value.value);

    // Exposures range from microseconds to minutes: a logarithmic scale, if no value is 0 or less.
    const auto flags =
        ImGuiSliderFlags_AlwaysClamp | (shown.value.least > 0 ? ImGuiSliderFlags_Logarithmic : 0);
    name_field(words.name);
    if (ImGui::SliderFloat(hidden_label(words.name).c_str(), &value,
                           static_cast<float>(shown.value.least),
                           static_cast<float>(shown.value.most), words.shown_as, flags)) {
      shown.value.value = static_cast<double>(value);
    }

    if (ImGui::IsItemDeactivatedAfterEdit()) requests.set_control = shown;
  }

  if (can_choose_exposure(state, source)) requests.expose |= ImGui::Button("Best exposure (E)");
  if (!source.camera_region.empty()) say(quiet, "region {}", source.camera_region);
}

void draw_actions(PanelState& state, PanelRequests& requests, const ViewSource& source) {
  if (source.save) {
    requests.save |= large_button(source.opens_saved ? "Capture (S)" : "Save (S)");
  }

  if (source.statistics) {
    state.paused ^= ImGui::Button(state.paused ? "Resume (Space)" : "Pause (Space)");
  }

  if (source.record) {
    if (source.statistics) ImGui::SameLine();
    const std::string recording = source.recording ? source.recording() : std::string();
    requests.toggle_recording |= ImGui::Button(recording.empty() ? "Record (R)" : "Stop (R)");
    if (!recording.empty()) say(bad, "recording: {}", recording);
  }

  if (!state.message.empty()) say(white, "{}", state.message);
}

/// The state of the source, and its calibration.
void draw_source(const PanelState& state, PanelRequests& requests, const ViewSource& source) {
  if (source.statistics && state.pixels != 0) {
    say(state.paused ? doubtful : good, "{}", state.paused ? "paused; capture goes on" : "live");
  }

  if (!source.setup) return;
  const Scanner& scanner = source.setup->scanner;
  if (!has_geometry(scanner)) {
    say(doubtful, "not calibrated: pictures only");
  } else if (!scanner.measured.empty()) {
    say(quiet, "calibrated: {}", scanner.measured);
  }

  if (source.check_rig) {
    requests.check_rig |= ImGui::Button("Compare rig (G)");
    const std::string rig = source.rig ? source.rig() : std::string();
    if (!rig.empty()) say(white, "{}", rig);
  }
}

void place_window(float left, float width, const PanelMargins& margins, const Screen& screen) {
  ImGui::SetNextWindowPos({left, margins.top});
  ImGui::SetNextWindowSize({width, static_cast<float>(screen.window.height) - margins.top});
}

}  // namespace

bool pictures_alone(const ViewSource& source) {
  return source.setup && !has_geometry(source.setup->scanner);
}

bool has_points(const PanelState& state, const ViewSource& source) {
  return state.counts.front() != 0 && !pictures_alone(source);
}

bool can_choose_exposure(const PanelState& state, const ViewSource& source) {
  return source.best_exposure && !state.camera.empty() &&
         state.camera.front().which == CameraControl::exposure;
}

std::string why_no_points(const PanelState& state) {
  const auto points = state.counts.front();
  if (state.pixels == 0 || points > state.pixels / 100) return {};

  std::string words = points == 0 ? "No points." : fmt::format("Almost no points: {}.", points);

  // The share of each reason, and the most frequent one.
  std::size_t most = 1;
  for (std::size_t i = 1; i < state.counts.size(); ++i) {
    if (state.counts[i] == 0) continue;
    words += fmt::format("\n{} of the pixels: {}", percent_of(state.counts[i], state.pixels),
                         name_of(static_cast<Validity>(i)));
    if (state.counts[i] > state.counts[most]) most = i;
  }

  // Advice, if the most frequent reason has a remedy.
  if (most == static_cast<std::size_t>(Validity::too_dark)) {
    words += "\nCheck that the projector lights the scene, or expose longer.";
  } else if (most == static_cast<std::size_t>(Validity::saturated)) {
    words += "\nShorten the exposure, or dim the projector.";
  }

  return words;
}

PanelMargins panel_margins(const PanelState& state, const ViewSource& source,
                           const Screen& screen) {
  if (!state.shown || (source.guide && !source.steps)) return {};

  const auto width = static_cast<float>(screen.window.width);
  const float left = std::min(286 * screen.unit(), 0.5F * width);
  const float right = std::min(300 * screen.unit(), 0.3F * width);
  const bool room = width >= 760 * screen.unit();

  return {left, source.setup && room ? right : 0, ImGui::GetFrameHeight()};
}

void draw_panel(PanelState& state, PanelRequests& requests, const ViewSource& source,
                const LiveStatistics& statistics, const Screen& screen) {
  draw_closing(state, requests, screen);

  const PanelMargins margins = panel_margins(state, source, screen);
  if (margins.left <= 0) return;

  draw_menus(state, requests, source);
  place_window(0, margins.left, margins, screen);
  if (ImGui::Begin("panel", nullptr, fixed_window)) {
    push_tab_stop(false);  // Tab would start typing into the next slider

    // Actions and problems first, since they must be seen without scrolling.
    draw_steps(requests, source);
    draw_source(state, requests, source);
    draw_actions(state, requests, source);
    draw_status(state, source, statistics);

    // How to show the pictures or the points.
    if (pictures_alone(source)) {
      if (section("View")) {
        choose("picture", {"camera (1)", "modulation (2)", "phase (3)"}, state.picture);
        say(saturated_ink, "red: a frame is saturated");
        say(too_dark_ink, "blue: too dark to measure");
      }
    } else if (state.pixels != 0) {
      draw_view_settings(state, requests);
      draw_filters(state, requests, source);
      draw_measuring(state);
    }

    // Settings of the camera and the scan, and files.
    draw_camera(state, requests, source);
    draw_scan_settings(state, requests, source);
    draw_files(state, requests, source);

    if (source.statistics) draw_speed(state, statistics);

    say(quiet, "{}Tab: hide this; Esc: close",
        pictures_alone(source) || state.pixels == 0
            ? ""
            : "drag: turn; right drag: move; wheel: zoom; ");

    pop_tab_stop();
  }
  ImGui::End();
}

void draw_pictures(PanelState& state, const std::array<opengl::PictureTexture, 3>& pictures,
                   const ViewSource& source, const Screen& screen) {
  static constexpr std::array<const char*, 3> titles{"Camera (red: saturated)", "Modulation",
                                                     "Wrapped phase"};

  const PanelMargins margins = panel_margins(state, source, screen);
  if (margins.right <= 0) return;

  place_window(static_cast<float>(screen.window.width) - margins.right, margins.right, margins,
               screen);
  if (ImGui::Begin("pictures", nullptr, fixed_window)) {
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      ImGui::SetNextItemOpen(state.picture_open[i]);
      state.picture_open[i] = ImGui::CollapsingHeader(titles[i]);

      const Size size = pictures[i].size();
      if (!state.picture_open[i] || size.width < 1 || size.height < 1) continue;

      // The picture, as wide as the column.
      const float width = ImGui::GetContentRegionAvail().x;
      const float height = width * static_cast<float>(size.height) / static_cast<float>(size.width);
      // Dear ImGui passes textures to its backend unchanged: here OpenGL's texture name.
      ImGui::Image(std::bit_cast<ImTextureID>(std::uintptr_t{pictures[i].number()}),
                   {width, height});

      // The histogram belongs to the camera's picture.
      if (i != 0) continue;
      ImGui::PlotHistogram("##grey levels", state.histogram.data(),
                           static_cast<int>(state.histogram.size()), 0, nullptr, 0, 1,
                           {width, 4 * ImGui::GetFontSize()});
      say(quiet, "grey levels of all frames, dark to bright");
    }
  }
  ImGui::End();
}

}  // namespace slipstream::view
