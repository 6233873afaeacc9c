#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <regex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/socket.h>

#include "base/numbers.h"
#include "base/system_failure.h"
#include "base/thread_priority.h"
#include "base/throw_if-inl.h"
#include "devices/gige_sockets.h"
#include "publish/cdr.h"
#include "publish/dds_messages.h"
#include "publish/ros_parameters.h"
#include "publish/sink_kind.h"
#include "publish/transform_message.h"

namespace slipstream {
namespace {

constexpr auto between_requests = DDS_MSECS(200);
constexpr std::size_t most_news = 64;

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

dds_entity_t made(dds_entity_t entity, std::string_view what) {
  if (entity >= 0) return entity;
  throw WorldError(fmt::format("`publish ros2`: {}: {}", what, dds_strretcode(-entity)));
}

using Qos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;

Qos quality(dds_reliability_kind_t reliability, int kept,
            dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE) {
  Qos qos(dds_create_qos(), &dds_delete_qos);
  dds_qset_durability(qos.get(), durability);
  dds_qset_reliability(qos.get(), reliability, DDS_SECS(1));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kept);
  return qos;
}

/// The process's UDP sockets that are bound to all addresses.
std::vector<int> open_sockets() {
  std::vector<int> sockets;
  for (const auto& [socket, address] : udp_sockets()) {
    if (address.sin_addr.s_addr == INADDR_ANY) sockets.push_back(socket);
  }
  return sockets;
}

/// Lets through only packets from this machine: Cyclone DDS binds sockets to all addresses even if
/// given one interface. Returns false, with errno, on failure.
bool bind_to_loopback(const std::vector<int>& sockets) {
  return std::ranges::all_of(sockets, [](int socket) {
    constexpr std::string_view loopback = "lo";
    return ::setsockopt(socket, SOL_SOCKET, SO_BINDTODEVICE, loopback.data(), loopback.size()) == 0;
  });
}

/// Joins the domain set by ROS 2's and Cyclone DDS's environment variables. Its log goes to the
/// sink's news, not to stderr.
class Domain {
 public:
  Domain() {
    // Cyclone DDS crashes if it cannot open all of its sockets and pipes.
    require_descriptors(64, "`publish ros2`");

    // 1. The domain's number.
    const std::string number = variable("ROS_DOMAIN_ID");
    const auto id = number_in<std::uint32_t>(number.empty() ? "0" : number);
    throw_if(!id || *id > 232, "ROS_DOMAIN_ID is '{}'; expected a number from 0 to 232", number);

    dds_set_log_sink(
        [](void* self, const dds_log_data_t* logged) {
          static_cast<Domain*>(self)->hear({logged->message, logged->size});
        },
        this);

    // 2. Configuration: the user's own, then ours, without shared memory, which these messages do
    // not support.
    std::string config = "<SharedMemory><Enable>false</Enable></SharedMemory>";
    const std::string own = variable("CYCLONEDDS_URI");
    const bool local = variable("ROS_LOCALHOST_ONLY") == "1";
    // Cyclone DDS rejects an interface named twice.
    if (local && own.find("<NetworkInterface") == own.npos) {
      config +=
          "<General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces></General>";
    }
    config = fmt::format("{}{}<CycloneDDS><Domain>{}</Domain></CycloneDDS>", own,
                         own.empty() ? "" : ",", config);

    // 3. Create the domain, and restrict the sockets that it opened.
    const std::vector<int> before = open_sockets();
    domain_ = dds_create_domain(*id, config.c_str());
    std::vector<int> opened = open_sockets();
    std::erase_if(opened, [&](int socket) { return std::ranges::count(before, socket) > 0; });

    if (local && !bind_to_loopback(opened)) {
      const std::string why = std::strerror(errno);
      leave();
      throw WorldError("ROS_LOCALHOST_ONLY: cannot bind to the loopback interface: " + why);
    }

    // 4. Join it. ROS 2 recognises its nodes by the enclave.
    const Qos qos(dds_create_qos(), &dds_delete_qos);
    constexpr std::string_view is_of_ros = "enclave=/;";
    dds_qset_userdata(qos.get(), is_of_ros.data(), is_of_ros.size());

    participant_ = domain_ < 0 ? domain_ : dds_create_participant(*id, qos.get(), nullptr);
    if (participant_ < 0) {
      const std::vector<std::string> why = news();
      leave();
      throw_if(domain_ == DDS_RETCODE_PRECONDITION_NOT_MET,
               "only one ROS 2 namespace per program is possible");
      throw WorldError(fmt::format("cannot join ROS 2's domain {}: {}", *id,
                                   why.empty() ? dds_strretcode(-participant_) : why.back()));
    }
  }

  ~Domain() { leave(); }

  [[nodiscard]] dds_entity_t participant() const { return participant_; }

  void hear(std::string line) {
    line.erase(line.find_last_not_of('\n') + 1);
    const std::lock_guard lock(mutex_);
    if (heard_++ < most_news) news_.push_back(std::move(line));
  }

  std::vector<std::string> news() {
    const std::lock_guard lock(mutex_);
    return std::exchange(news_, {});
  }

 private:
  void leave() {
    if (domain_ >= 0) dds_delete(domain_);  // with everything created in it
    dds_set_log_sink(nullptr, nullptr);
  }

  std::mutex mutex_;  ///< guards the two members below
  std::vector<std::string> news_;
  std::size_t heard_ = 0;
  dds_entity_t domain_ = 0, participant_ = 0;
};

/// "sensor_msgs::msg::dds_::Image_" of "sensor_msgs/msg/Image".
std::string dds_name(const std::string& type) {
  const std::size_t slash = type.find('/'), last = type.rfind('/');
  return fmt::format("{}::{}::dds_::{}_", type.substr(0, slash),
                     type.substr(slash + 1, last - slash - 1), type.substr(last + 1));
}

/// A topic: messages of one type.
class MessageWriter {
 public:
  /// `type`: e.g. "sensor_msgs/msg/Image".
  MessageWriter(dds_entity_t participant, const std::string& name, const std::string& type,
                const Qos& qos) {
    const dds_entity_t topic = made(create_message_topic(participant, name, dds_name(type)), name);
    writer_ = made(dds_create_writer(participant, topic, qos.get(), nullptr), name);
  }

  [[nodiscard]] bool is_heard() const {
    dds_publication_matched_status_t listeners;
    dds_get_publication_matched_status(writer_, &listeners);
    return listeners.current_count > 0;
  }

  template <class Write>
  void write(Write write_message) {
    if (message_.use_count() != 1) message_ = std::make_shared<RosMessage>();  // DDS still holds it
    write_message(*message_);
    pad(*message_);

    const SharedMessage message = message_;
    made(dds_write(writer_, &message), "a message");
  }

 private:
  dds_entity_t writer_;
  std::shared_ptr<RosMessage> message_;
};

/// A service, answered in the thread that calls answer().
class Service {
 public:
  Service(dds_entity_t participant, const RosService& service) : answer_(service.answer) {
    const std::string& name = service.name;

    const Qos qos = quality(DDS_RELIABILITY_RELIABLE, 10);
    const auto topic = [&](const char* prefix, const char* ending, const char* type) {
      return made(
          create_message_topic(participant, prefix + name + ending, dds_name(service.type + type)),
          name);
    };

    // ROS 2's names of a service: rq/ for requests, rr/ for replies.
    const dds_entity_t requests = topic("rq/", "Request", "_Request"),
                       answers = topic("rr/", "Reply", "_Response");

    dds_guid_t participant_id;
    dds_instance_handle_t number = 0;
    made(dds_get_guid(participant, &participant_id), name);
    made(dds_get_instance_handle(requests, &number), name);

    // Tells ROS 2 that this reader and writer belong to one service.
    const std::string id =
        fmt::format("serviceid={:02x}.{:x};", fmt::join(participant_id.v, "."), number);
    dds_qset_userdata(qos.get(), id.data(), id.size());

    reader_ = made(dds_create_reader(participant, requests, qos.get(), nullptr), name);
    writer_ = made(dds_create_writer(participant, answers, qos.get(), nullptr), name);
  }

  [[nodiscard]] dds_entity_t reader() const { return reader_; }

  /// Answers all pending requests, until `stop`.
  void answer_requests(const std::atomic<bool>& stop) {
    SharedMessage request;
    void* sample = &request;
    dds_sample_info_t info;
    while (!stop && dds_take(reader_, &sample, &info, 1, 1) == 1) {
      if (info.valid_data && request) answer(*request);
    }
  }

 private:
  void answer(const RosMessage& request) try {
    const auto message = std::make_shared<RosMessage>();

    CdrReader reader(request);
    Cdr answer(*message);
    answer.add(reader.get<std::uint64_t>());  // the client, over Cyclone DDS
    answer.add(reader.get<std::int64_t>());   // its number of the request

    answer_(reader, answer);
    pad(*message);
    const SharedMessage written = message;
    dds_write(writer_, &written);    // skips clients that no longer listen
  } catch (const std::exception&) {  // and unknown request formats
  }

  std::function<void(CdrReader& request, Cdr& answer)> answer_;
  dds_entity_t reader_, writer_;
};

class Ros2Sink final : public DisjointCloudSink {
 public:
  Ros2Sink(const std::string& name, PublishedRun run) : run_(std::move(run)), name_(name) {
    // 1. Topics and services.
    add(image_topic());
    if (run_.has_points) {
      for (const auto& topic : {camera_info_topic(), depth_topic(), points_topic()}) add(topic);
    }

    if (run_.frame) add_transform();
    add_trigger("capture", [this] { return run_.save(); });
    add_trigger("check", [this] { return check(); });
    if (run_.settings) {
      for (const RosService& service : parameter_services(name, run_)) {
        services_.emplace_back(participant_, service);
      }
    }

    // 2. The serving thread waits for requests to any service, or for the end.
    waiting_ = made(dds_create_waitset(participant_), name);
    wake_ = made(dds_create_guardcondition(participant_), name);
    made(dds_waitset_attach(waiting_, wake_, 0), name);

    for (const Service& service : services_) {
      const dds_entity_t any =
          made(dds_create_readcondition(service.reader(), DDS_ANY_STATE), name);
      made(dds_waitset_attach(waiting_, any, 0), name);
    }

    // 3. Announce the node and begin.
    tell_node();
    thread_ = std::thread([this] { serve(); });
  }

  ~Ros2Sink() override { Ros2Sink::finish(); }

  void put(const Pooled<LiveCloud>& cloud, bool alone) override {
    const PublishedCloud published{*cloud, run_, alone};
    for (auto& [topic, writer] : topics_) {
      if (!writer.is_heard()) continue;
      writer.write([&](RosMessage& message) { topic.write(published, message); });
    }
  }

  void finish() override {
    stopping_ = true;
    dds_set_guardcondition(wake_, true);
    if (thread_.joinable()) thread_.join();
  }

  std::vector<std::string> news() override { return domain_.news(); }

 private:
  void add(const CloudTopic& topic) {
    topics_.emplace_back(
        topic, MessageWriter(participant_, "rt/" + name_ + "/" + topic.name, topic.type.name,
                             quality(DDS_RELIABILITY_BEST_EFFORT, 5)));
  }

  /// Where the camera is, also for those who listen later.
  void add_transform() {
    transform_.emplace(participant_, fmt::format("rt/{}", transform_topic), transform_type().name,
                       quality(DDS_RELIABILITY_RELIABLE, 1, DDS_DURABILITY_TRANSIENT_LOCAL));
    transform_->write([&](RosMessage& message) {
      const std::uint64_t now = world_time(std::chrono::steady_clock::now());
      write_transform(*run_.frame, run_.frame_id, now, message);
    });
  }

  void serve() {
    let_others_go_first();
    try {
      while (!stopping_ && dds_waitset_wait(waiting_, nullptr, 0, between_requests) >= 0) {
        for (Service& service : services_) service.answer_requests(stopping_);
        if (run_.settings) tell_changes();
      }
    } catch (const std::exception& error) {
      domain_.hear(fmt::format("requests are no longer answered: {}", error.what()));
    }
  }

  /// A std_srvs/srv/Trigger service.
  void add_trigger(const char* what, std::function<std::string()> pulled) {
    services_.emplace_back(participant_,
                           RosService{name_ + "/" + what, "std_srvs/srv/Trigger",
                                      [pulled = std::move(pulled)](CdrReader&, Cdr& answer) {
                                        add_outcome(answer, pulled);
                                      }});
  }

  [[nodiscard]] std::string check() const {
    std::vector<std::string> problems;
    // Problems that last: the source's, and findings that have not ended.
    if (std::string trouble = run_.trouble(); !trouble.empty()) problems.push_back(trouble);
    const auto document = nlohmann::json::parse(run_.statistics());
    for (const auto& finding : document.value("findings", nlohmann::json::array())) {
      if (finding.at("end").is_null()) problems.push_back(finding.at("what").get<std::string>());
    }

    if (problems.empty()) return "OK: no problems found";
    throw Error(fmt::format("{}", fmt::join(problems, "; ")));
  }

  /// Publishes settings changed by any sink or the viewer.
  void tell_changes() try {
    if (!events_.is_heard()) return;
    std::vector<RunSetting> now = run_.settings();

    RosMessage event;
    const std::uint64_t time = world_time(std::chrono::steady_clock::now());
    if (write_parameter_event(name_, time, published_, now, event)) {
      events_.write([&](RosMessage& message) { message.swap(event); });
    }

    published_ = std::move(now);
  } catch (const std::exception&) {  // the camera is shutting down or there is no reader: try later
  }

  /// rmw_dds_common/msg/ParticipantEntitiesInfo of the node. Identities have 24 bytes up to ROS 2
  /// Humble.
  void tell_node() {
    const std::size_t spare = variable("ROS_DISTRO") == "humble" ? 8 : 0;
    const std::string whole = fmt::format("/{}", name_);
    const std::size_t last = whole.rfind('/');

    dds_guid_t id;
    made(dds_get_guid(participant_, &id), name_);

    node_.write([&](RosMessage& message) {
      Cdr cdr(message);
      for (const std::uint8_t byte : id.v) cdr.add(byte);
      for (std::size_t i = 0; i < spare; ++i) cdr.add(std::uint8_t{0});
      // One node, by namespace and name, with empty lists of readers and writers.
      cdr.add_count(1).add_text(whole.substr(0, std::max<std::size_t>(last, 1)));
      cdr.add_text(whole.substr(last + 1)).add_count(0).add_count(0);
    });
  }

  const PublishedRun run_;
  const std::string name_;
  Domain domain_;
  const dds_entity_t participant_ = domain_.participant();
  std::vector<std::pair<CloudTopic, MessageWriter>> topics_;
  MessageWriter events_{participant_, "rt/parameter_events", "rcl_interfaces/msg/ParameterEvent",
                        quality(DDS_RELIABILITY_RELIABLE, 100)};
  MessageWriter node_{participant_, "ros_discovery_info",
                      "rmw_dds_common/msg/ParticipantEntitiesInfo",
                      quality(DDS_RELIABILITY_RELIABLE, 1, DDS_DURABILITY_TRANSIENT_LOCAL)};
  std::optional<MessageWriter> transform_;
  std::vector<Service> services_;
  std::vector<RunSetting> published_;  ///< serving thread only
  dds_entity_t waiting_ = 0, wake_ = 0;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

/// "scanner" from "scanner" or "/scanner"; throws Error for an invalid ROS 2 namespace.
std::string ros_namespace(const std::string& text) {
  static const std::regex form(R"(/?((?!.*__)[A-Za-z_]\w*(/[A-Za-z_]\w*)*))");
  std::smatch found;
  if (std::regex_match(text, found, form)) return found[1];
  throw Error(
      fmt::format("`publish ros2:{}`: expected a ROS 2 namespace, e.g. ros2:scanner or "
                  "ros2:cell/left: letters, digits and single _, no digit first",
                  text));
}

}  // namespace

const SinkKind ros2_sink{
    "ros2", "ros2:NAMESPACE", [](const std::string& name) { (void)ros_namespace(name); },
    [](const std::string& name, PublishedRun run) -> std::unique_ptr<CloudSink> {
      return std::make_unique<Ros2Sink>(ros_namespace(name), std::move(run));
    }};

}  // namespace slipstream
