#include "bench/vector_target.h"

#include <cstdint>

#include <fmt/ranges.h>
#include <hwy/targets.h>

#include "slipstream/error.h"

namespace slipstream {
namespace {

std::vector<std::int64_t> compiled_targets() {
  std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  if (targets.empty() || targets.back() != HWY_STATIC_TARGET) targets.push_back(HWY_STATIC_TARGET);
  return targets;
}

}  // namespace

std::vector<std::string> vector_targets() {
  std::vector<std::string> names;
  for (const std::int64_t target : compiled_targets()) names.emplace_back(hwy::TargetName(target));
  return names;
}

OnlyVectorTarget::OnlyVectorTarget(const std::string& name) {
  for (const std::int64_t target : compiled_targets()) {
    if (name != hwy::TargetName(target)) continue;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return;
  }
  throw Error(fmt::format("vector target '{}' is not available; expected one of: {}", name,
                          fmt::join(vector_targets(), ", ")));
}

OnlyVectorTarget::~OnlyVectorTarget() {
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace slipstream
