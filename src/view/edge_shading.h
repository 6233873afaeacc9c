#pragma once

#include "view/opengl.h"

namespace slipstream::view {

/// A part of the framebuffer from its lower edge up, in pixels.
struct Pane {
  int left = 0;
  Size size;
};

/// Eye-dome lighting (Boucheny 2009): darkens what lies behind its surroundings on the picture, so
/// that edges and relief show without normals.
class EdgeShading {
 public:
  EdgeShading();

  /// Darkens a pane of the bound framebuffer, drawn with `clip_matrix`, by its depths. `reach`: of
  /// the surroundings, pixels. `noise`: of the distance from the eye, as a share of it.
  void draw(const Pane& pane, int reach, float noise) const;

 private:
  opengl::ShaderProgram program_;
  opengl::Resource vertex_array_, depths_;
};

}  // namespace slipstream::view
