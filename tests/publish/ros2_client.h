#pragma once

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include <dds/dds.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/app/program.h"

namespace slipstream {

/// Chooses a DDS domain for this process alone, on loopback without multicast.
inline void choose_domain() {
  ::setenv("ROS_DOMAIN_ID", std::to_string(1 + ::getpid() % 200).c_str(), 1);
  ::setenv("ROS_LOCALHOST_ONLY", "1", 1);
  ::setenv("CYCLONEDDS_URI",
           "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast>"
           "<Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces></General>"
           "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
           "<Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery>"
           "<Internal><SocketReceiveBufferSize min=\"4MB\"/></Internal></Domain></CycloneDDS>",
           1);
}

/// Runs a function in a child process; the destructor kills it if it is still running.
class Child {
 public:
  explicit Child(const std::function<void()>& work) : process_(::fork()) {
    if (process_ != 0) return;
    work();
    ::_exit(0);
  }
  ~Child() {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  [[nodiscard]] pid_t process() const { return process_; }

  [[nodiscard]] long resident_pages() const {
    std::ifstream file(fmt::format("/proc/{}/statm", process_));
    long all = 0, resident = 0;
    file >> all >> resident;
    return resident;
  }

 private:
  pid_t process_;
};

/// A ROS 2 participant.
struct Client {
  Client() {
    choose_domain();
    const auto id = static_cast<dds_domainid_t>(std::atoi(std::getenv("ROS_DOMAIN_ID")));
    participant = dds_create_participant(id, nullptr, nullptr);
  }
  ~Client() { dds_delete(participant); }

  [[nodiscard]] dds_entity_t reader(const dds_topic_descriptor_t& type, const std::string& name,
                                    bool reliable = false, bool lasting = false) const {
    dds_qos_t* const qos = dds_create_qos();
    if (lasting) dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                         DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 5);
    const auto topic = dds_create_topic(participant, &type, name.c_str(), nullptr, nullptr);
    const auto made = dds_create_reader(participant, topic, qos, nullptr);
    dds_delete_qos(qos);
    return made;
  }

  dds_entity_t participant;
};

/// Calls `see` for each message received; returns whether there was one.
template <class Message>
bool take(dds_entity_t reader, const std::function<void(const Message&)>& see) {
  void* sample = nullptr;
  dds_sample_info_t info;
  bool saw = false;
  while (dds_take(reader, &sample, &info, 1, 1) == 1) {
    if (info.valid_data) {
      see(*static_cast<const Message*>(sample));
      saw = true;
    }
    dds_return_loan(reader, &sample, 1);
    sample = nullptr;
  }
  return saw;
}

/// A ROS 2 service client over Cyclone DDS; repeats each request until it is answered.
template <class Request, class Response>
struct ServiceCaller {
  ServiceCaller(const Client& client, const std::string& name,
                const dds_topic_descriptor_t& request, const dds_topic_descriptor_t& response) {
    const auto topic = dds_create_topic(client.participant, &request,
                                        ("rq/" + name + "Request").c_str(), nullptr, nullptr);
    writer = dds_create_writer(client.participant, topic, nullptr, nullptr);
    reader = client.reader(response, "rr/" + name + "Reply", true);
    wait_until([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      dds_publication_matched_status_t to{};
      dds_subscription_matched_status_t from{};
      dds_get_publication_matched_status(writer, &to);
      dds_get_subscription_matched_status(reader, &from);
      return to.current_count > 0 && from.current_count > 0;
    });
  }
  void call(Request request, const std::function<void(const Response&)>& see) {
    request.guid = 0xfedcba9876543210U;
    request.seq = ++number;
    dds_write(writer, &request);
    bool came = false;
    wait_until([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      came = came || take<Response>(reader, [&](const Response& told) {
               EXPECT_EQ(told.guid, request.guid);
               EXPECT_EQ(told.seq, number);
               see(told);
             });
      return came;
    });
    EXPECT_TRUE(came);
  }

  dds_entity_t writer, reader;
  std::int64_t number = 0;
};

}  // namespace slipstream
