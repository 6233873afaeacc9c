#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/view/window.h"

namespace slipstream::view {

/// What a guided person is to see.
struct Guide {
  Image<Colour> picture;
  std::string headline;            ///< large, below the picture
  Colour colour{255, 255, 255};    ///< of the headline
  std::vector<std::string> lines;  ///< below it
};

/// A window that shows a picture and what to do next. In the main thread; its text grows with the
/// window, to be read from where the board is.
class GuideWindow {
 public:
  /// Throws WorldError where the desktop or its OpenGL does not give a window.
  GuideWindow(const opengl::WindowSystem& system, const std::string& title, Size size);
  ~GuideWindow();
  GuideWindow(const GuideWindow&) = delete;
  GuideWindow& operator=(const GuideWindow&) = delete;

  /// Draws it.
  void show(Guide guide);
  /// Whether it was closed, or Esc pressed. Answers the desktop meanwhile.
  [[nodiscard]] bool closed() const;
  /// What it showed last.
  [[nodiscard]] Image<Colour> picture() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace slipstream::view
