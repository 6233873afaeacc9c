#pragma once

namespace slipstream::app {

/// Memory of one scan serves the next: what goes back to the system comes again page by page,
/// zeroed, which costs more than reconstructing. Large pages make that cheaper the first time.
void keep_memory();

}  // namespace slipstream::app
