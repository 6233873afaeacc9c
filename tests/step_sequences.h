#pragma once

#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

namespace slipstream {

/// Calls take(sequence) for random sequences of these steps, up to `longest` each. It throws, e.g.
/// by RC_ASSERT, when something is not as its model says; rapidcheck then looks for a shorter
/// sequence that fails.
template <class Take>
void check_sequences(const std::vector<std::string>& steps, int sequences, int longest,
                     const Take& take) {
  rc::detail::TestParams params = rc::detail::configuration().testParams;
  params.maxSuccess = sequences;
  params.maxSize = longest;

  const auto result = rc::detail::checkTestable(
      [&] { take(*rc::gen::container<std::vector<std::string>>(rc::gen::elementOf(steps))); },
      rc::detail::TestMetadata(), params);

  std::ostringstream why;
  rc::detail::printResultMessage(result, why);
  EXPECT_TRUE(result.template is<rc::detail::SuccessResult>()) << why.str();
}

}  // namespace slipstream
