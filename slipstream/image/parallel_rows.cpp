#include "slipstream/image/parallel_rows.h"

#include <tbb/parallel_for.h>

namespace slipstream {

void for_each_row(int height, const std::function<void(int row)>& body) {
  tbb::parallel_for(0, height, body);
}

}  // namespace slipstream
