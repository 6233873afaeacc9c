#include <array>
#include <atomic>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/cloud_sink.h"
#include "slipstream/error.h"

namespace slipstream::publisher_test {

/// Records the clouds it gets; put() blocks until `may` is ready.
struct SlowSink : CloudSink {
  explicit SlowSink(std::shared_future<void> when) : may(std::move(when)) {}
  void put(const Pooled<LiveCloud>& cloud, bool alone) override {
    began = true;
    may.wait();
    seen.push_back(cloud->newest.sequence);
    went_alone.push_back(alone);
  }
  void finish() override { finished = true; }
  std::vector<std::string> news() override { return {"hello"}; }

  std::shared_future<void> may;
  std::vector<std::uint64_t> seen;
  std::vector<bool> went_alone;
  std::atomic<bool> began = false;
  bool finished = false;
};

struct FailingSink : CloudSink {
  void put(const Pooled<LiveCloud>&, bool) override { throw WorldError("the disk is full"); }
};

Pooled<LiveCloud> cloud_of(Pool<LiveCloud>& pool, std::uint64_t sequence) {
  Pooled<LiveCloud> cloud = pool.take();
  cloud.fill().newest.sequence = sequence;
  return cloud;
}

TEST(Publisher, WaitsForNoSinkDropsTheOldestAndSaysSoOnce) {
  std::promise<void> may;
  const std::shared_future<void> when = may.get_future().share();
  auto slow = std::make_unique<SlowSink>(when);
  const SlowSink& sink = *slow;
  Pool<LiveCloud> pool(3 * Publisher::held_clouds, [] { return LiveCloud(); });
  Publisher publisher;
  publisher.add("slow", std::move(slow));
  publisher.add("broken", std::make_unique<FailingSink>());
  for (std::uint64_t i = 0; i < 40; ++i) {
    const Pooled<LiveCloud> cloud = cloud_of(pool, i);
    ASSERT_TRUE(cloud) << "the sinks hold more than they may, at " << i;
    publisher.publish(cloud);
    while (i == 0 && !sink.began) std::this_thread::yield();
  }
  std::vector<std::string> said, warned;
  const auto tell = [&] {
    publisher.tell([&](const std::string& line) { said.push_back(line); },
                   [&](const std::string& line) { warned.push_back(line); });
  };
  while (publisher.statistics()[1].error.empty()) std::this_thread::yield();
  tell();
  tell();
  may.set_value();
  publisher.finish();
  publisher.finish();

  const SinkStatistics statistics = publisher.statistics().front();
  EXPECT_EQ(statistics.published, 5U);
  EXPECT_EQ(statistics.dropped, 35U);
  EXPECT_EQ(sink.seen, (std::vector<std::uint64_t>{0, 36, 37, 38, 39})) << "the newest";
  EXPECT_EQ(sink.went_alone, (std::vector<bool>{false, true, true, true, false}))
      << "from the first that was dropped until none waits";
  EXPECT_TRUE(sink.finished);
  EXPECT_EQ(said, (std::vector<std::string>{"slow: hello", "slow: hello"}));
  ASSERT_EQ(warned.size(), 2U);
  EXPECT_NE(warned[0].find("slow: too slow"), std::string::npos) << warned[0];
  EXPECT_NE(warned[1].find("broken: the disk is full"), std::string::npos) << warned[1];
}

TEST(Publisher, NamedSinkSaysWhichKindsThereAre) {
  const auto refusal = [](const std::string& name) -> std::string {
    try {
      require_sink(name);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  for (const char* bad : {"wbe:8080", "ros:/a", "", "web"}) {
    EXPECT_NE(refusal(bad).find("web:[ADDRESS:]PORT"), std::string::npos) << refusal(bad);
  }
  EXPECT_NE(refusal("wbe:8080").find("did you mean web?"), std::string::npos);
  EXPECT_NE(refusal("mcap:").find("mcap:FILE"), std::string::npos);
  EXPECT_NE(refusal("mcap:cloud.ply").find(".mcap"), std::string::npos);
  for (const char* bad :
       {"web:x", "web:70000", "web:-1", "web:here:8080", "web:1.2.3:80", "web: 1"}) {
    EXPECT_NE(refusal(bad).find("web:8080"), std::string::npos) << bad << refusal(bad);
  }
  for (const char* good :
       {"web:0", "web:8080", "web:0.0.0.0:8080", "web:[::1]:80", "mcap:a.mcap"}) {
    EXPECT_EQ(refusal(good), "");
  }
}

TEST(Publisher, RunSettingTakesWhatItCanBeAndSaysWhatThatIs) {
  const std::vector<RunSetting> settings{
      {.name = "exposure", .help = "", .unit = "ms", .least = 0.1, .most = 50},
      {.name = "record", .help = "", .choices = {"off", "on"}}};
  EXPECT_NO_THROW(require_settable(settings, "exposure", "12.5"));
  EXPECT_NO_THROW(require_settable(settings, "record", "on"));
  for (const auto& [name, value, part] :
       std::vector<std::array<const char*, 3>>{{"exposre", "1", "did you mean exposure?"},
                                               {"exposure", "51", "from 0.1 to 50 ms"},
                                               {"exposure", "nan", "a number"},
                                               {"exposure", "1 ", "a number"},
                                               {"exposure", "", "a number"},
                                               {"record", "om", "off; on"}}) {
    try {
      require_settable(settings, name, value);
      ADD_FAILURE() << name << " " << value;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
}

}  // namespace slipstream::publisher_test
