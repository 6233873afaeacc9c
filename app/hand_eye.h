#pragma once

namespace slipstream::app {

/// Help of `--table-columns` in the commands that read poses of a robot.
inline constexpr const char* columns_help =
    "names of the file's columns if it has none, e.g. name,x,y,z,rx,ry,rz; - ignores one";

}  // namespace slipstream::app
