#pragma once

#include "merge/model_surface.h"

namespace slipstream {

/// Closes each hole of a mesh that is at most `widest` mm across (diagonal of the box around its
/// rim) by triangles between the vertices of its rim. Their surface is a guess: no view saw it. The
/// rim of an open surface counts as a hole, too. Pieces of less than a hundredth of the largest
/// one's triangles keep their rims; a rim whose triangles would meet others along an edge stays
/// open. Returns the number of holes closed.
int fill_holes(ModelMesh& mesh, float widest);

}  // namespace slipstream
