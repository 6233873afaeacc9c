#include <chrono>
#include <exception>
#include <functional>
#include <future>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "io/file.h"
#include "slipstream/cloud_file.h"
#include "slipstream/surface.h"
#include "view/cloud_screen.h"

// How a screen opens and writes files.
namespace slipstream::view {

void CloudScreen::open(const std::string& path) {
  if (!source_.open) return;

  attempt([&] {
    auto opened = source_.open(path);
    if (!opened) return;

    opened->open = source_.open;
    opened->openable = source_.openable;
    opened->steps = source_.steps;

    next_ = [source = *std::move(opened)] { return source; };
  });
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
    const std::string path = saving_.get();
    if (source_.opens_saved) {
      // The opened scan gets a screen of its own, which keeps the steps and their message.
      if (source_.steps) source_.steps->message = fmt::format("saved: {}", path);
      return open(path);
    }
    state_.message = fmt::format("saved: {}", path);
  } catch (const std::exception& error) {
    state_.message = fmt::format("not saved: {}", source_.worded(error.what()));
  }
}

void CloudScreen::take_file(const FileRequest& request) {
  if (request.path.empty()) {
    if (asking_.valid()) return;
    asked_ = request.question;
    asking_ = std::async(std::launch::async, ask_for_file, asked_, std::cref(given_up_));
  } else if (request.question == FileQuestion::open) {
    open(request.path);
  } else {
    write(request.path);
  }
}

void CloudScreen::hear_of_dialog() {
  if (!asking_.valid()) return;
  if (asking_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;

  std::optional<std::string> path;
  if (attempt([&] { path = asking_.get(); }) && path) take_file({asked_, *path});
}

void CloudScreen::write(const std::string& path) {
  if (!cloud_) return;

  const Cloud& cloud = *cloud_.cloud;
  const std::string ending = lower_case_extension(path);
  const bool is_mesh = ending == ".stl" || ending == ".obj" || ending == ".glb";

  const bool written = attempt([&] {
    if (is_mesh) {
      Surface surface = surface_of(cloud);
      if (source_.frame) move_to_frame(surface, *source_.frame);
      return write_surface(path, surface);
    }

    CloudExtras extras{.uncertainty = cloud_.uncertainty.get(), .frame = source_.frame};
    for (const std::string& doubt : doubts(cloud_.findings)) {
      extras.remarks.push_back(source_.worded(doubt));
    }
    write_cloud(path, cloud, extras);
  });
  if (!written) return;

  state_.message = fmt::format("saved: {}", path);
  state_.path.fill('\0');  // the next time a dialog asks before it overwrites
}

}  // namespace slipstream::view
