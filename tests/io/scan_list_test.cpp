#include <cmath>
#include <numeric>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "io/result_files.h"
#include "slipstream/error.h"
#include "tests/io/expect_error.h"

namespace slipstream::scan_list_test {

TEST(ScanList, ReadsLinesAsTheyAreWritten) {
  const std::vector<ListedScans> scans = scan_list_from(
      "scans/my scan\na.slip\t3:5\n\nb.slip\t:\nc\t\t900\nd.slip\t7\t20\t4", "list.txt");
  const std::vector<ListedScans> wanted{
      {.path = "scans/my scan"},
      {.path = "a.slip", .windows = WindowRange{3, 5}},
      {.path = "b.slip", .windows = WindowRange{}},
      {.path = "c", .cost = 900},
      {.path = "d.slip", .windows = WindowRange{7, 8}, .cost = 20, .shard = 4}};
  EXPECT_EQ(scans, wanted);
  EXPECT_EQ(scan_list_from(text_of(scans), "again"), wanted);
  for (const char* bad : {"\t3:5", "a\t3:3", "a\tb", "a\t1:2\t-3", "a\t\t99999999999999999",
                          "a\t\t1\t2\t3", "a\t1:2:3", "a\t18446744073709551616:"}) {
    expect_error([&] { (void)scan_list_from(bad, "list.txt"); }, {"list.txt: line 1: "});
  }
  expect_error([] { (void)text_of(std::vector<ListedScans>{{.path = "a\nb"}}); }, {"line break"});
  for (const std::uint64_t end : {std::uint64_t{10'000'001}, WindowRange::last}) {
    expect_error(
        [&] {
          (void)scan_names({{.path = "a", .windows = WindowRange{0, end}}}, 1);
        },
        {"a: more than 10000000 scans"});
  }
}

RC_GTEST_PROP(ScanList, ShardsAreAllScansOnceInTheirOrderAndOfEvenCost, ()) {
  const auto every = *rc::gen::inRange<std::uint64_t>(1, 5);
  const auto shards = *rc::gen::inRange<std::uint64_t>(1, 30);
  std::vector<ListedScans> scans;
  double all = 0, most = 0;
  for (int i = *rc::gen::inRange(1, 9); i > 0; --i) {
    ListedScans listed{.path = std::to_string(i), .cost = *rc::gen::inRange<std::uint64_t>(1, 9)};
    if (*rc::gen::arbitrary<bool>()) {
      const auto first = *rc::gen::inRange<std::uint64_t>(0, 40);
      listed.windows = WindowRange{first, first + *rc::gen::inRange<std::uint64_t>(1, 90)};
    }
    most = std::max(most, static_cast<double>(listed.cost));
    listed.cost *= scan_count(listed, every);
    all += static_cast<double>(listed.cost);
    scans.push_back(listed);
  }
  const std::vector<ListedScans> pieces = cut_into_shards(scans, every, shards);
  RC_ASSERT(scan_names(pieces, every) == scan_names(scans, every));
  std::vector<double> costs(shards);
  std::uint64_t last = 1;
  for (const ListedScans& piece : pieces) {
    RC_ASSERT(piece.shard >= last && piece.shard <= shards);
    last = piece.shard;
    costs[piece.shard - 1] += static_cast<double>(piece.cost);
  }
  RC_ASSERT(std::accumulate(costs.begin(), costs.end(), 0.0) == all);
  for (const double cost : costs) {
    RC_ASSERT(std::abs(cost - all / static_cast<double>(shards)) <= most + 1e-6);
  }
}

}  // namespace slipstream::scan_list_test
