#pragma once

#include "app/commands.h"

namespace slipstream::app {

inline constexpr const char* columns_help =
    "names of the file's columns if it has none, e.g. name,x,y,z,rx,ry,rz; - ignores one";

/// Adds `calibrate hand-eye`, which finds the camera on a robot or beside it.
void add_calibrate_hand_eye(const Commands& calibrate);

/// Adds `calibrate touch`, which checks that with a tip on points.
void add_calibrate_touch(const Commands& calibrate);

/// Adds `calibrate projection`, which checks it with the projector's light on a board.
void add_calibrate_projection(const Commands& calibrate);

/// Adds `calibrate stitch`, which checks it with two views of a scene.
void add_calibrate_stitch(const Commands& calibrate);

/// Adds `calibrate virtual-robot`, which writes poses to rehearse with.
void add_calibrate_virtual_robot(const Commands& calibrate);

}  // namespace slipstream::app
