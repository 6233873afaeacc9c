#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <rclcpp/rclcpp.hpp>
#include <rclcpp_components/register_node_macro.hpp>
#include <rclcpp_lifecycle/lifecycle_node.hpp>
#include <slipstream/cloud_file.h>
#include <slipstream/cloud_sink.h>
#include <slipstream/error.h>
#include <slipstream/live_pipeline.h>
#include <slipstream/named_source.h>
#include <slipstream/ros_messages.h>
#include <slipstream/scan_files.h>
#include <slipstream/strategy.h>
#include <std_srvs/srv/trigger.hpp>

namespace slipstream_ros {
using namespace slipstream;
namespace {

/// Publishes clouds as serialised CDR messages of a node.
class NodeSink final : public DisjointCloudSink {
 public:
  NodeSink(rclcpp_lifecycle::LifecycleNode& node, PublishedRun run) : run_(std::move(run)) {
    for (const auto& topic : {camera_info_topic(), image_topic(), depth_topic(), points_topic()}) {
      topics_.emplace_back(topic, rclcpp::create_generic_publisher(
                                      node.get_node_topics_interface(), "~/" + topic.name,
                                      topic.type.name, rclcpp::SensorDataQoS()));
    }
  }

  void put(const Pooled<LiveCloud>& cloud, bool alone) override {
    const PublishedCloud published{*cloud, run_, alone};
    for (const auto& [topic, publisher] : topics_) {
      if (publisher->get_subscription_count() == 0) continue;
      topic.write(published, message_);
      rclcpp::SerializedMessage serialized(message_.size());
      auto& raw = serialized.get_rcl_serialized_message();
      std::memcpy(raw.buffer, message_.data(), message_.size());
      raw.buffer_length = message_.size();
      publisher->publish(serialized);
    }
  }

 private:
  const PublishedRun run_;
  std::vector<std::pair<CloudTopic, rclcpp::GenericPublisher::SharedPtr>> topics_;
  RosMessage message_;
};

}  // namespace

/// Configured, it has its camera; active, it publishes clouds. Parameters: config/scanner.yaml.
class ScannerNode final : public rclcpp_lifecycle::LifecycleNode {
  using State = rclcpp_lifecycle::State;
  using Trigger = std_srvs::srv::Trigger;

 public:
  explicit ScannerNode(const rclcpp::NodeOptions& options) : LifecycleNode("scanner", options) {
    declare_parameter<std::string>("source", "aravis:");
    declare_parameter<std::string>("scanner", "");
    declare_parameter<std::string>("strategy", "");
    declare_parameter<double>("exposure", 0.0);
    declare_parameter<std::string>("frame_id", std::string(camera_frame));
    declare_parameter<bool>("loop", false);
    declare_parameter<std::string>("save_to", ".");
  }
  ~ScannerNode() override { forget(); }

  CallbackReturn on_configure(const State&) override { return succeeds(&ScannerNode::configure); }
  CallbackReturn on_activate(const State&) override { return succeeds(&ScannerNode::start); }
  CallbackReturn on_deactivate(const State&) override { return succeeds(&ScannerNode::stop); }
  CallbackReturn on_cleanup(const State&) override { return succeeds(&ScannerNode::forget); }
  CallbackReturn on_shutdown(const State&) override { return succeeds(&ScannerNode::forget); }

 private:
  CallbackReturn succeeds(void (ScannerNode::*work)()) {
    try {
      (this->*work)();
      return CallbackReturn::SUCCESS;
    } catch (const std::exception& error) {
      RCLCPP_ERROR(get_logger(), "%s", error.what());
      return CallbackReturn::FAILURE;
    }
  }

  [[nodiscard]] std::string text(const char* name) const { return get_parameter(name).as_string(); }

  void configure() {
    SourceRequest request;
    request.source = text("source");
    request.loop = get_parameter("loop").as_bool();
    if (const std::string file = text("scanner"); !file.empty()) request.scanner = file;
    if (const std::string label = text("strategy"); !label.empty()) {
      request.sequence.known.emplace().strategy = strategy_labelled(label);
    }
    const double exposure = get_parameter("exposure").as_double();
    if (exposure > 0) request.camera.exposure = exposure / 1000;
    NamedSource source = open_source(request);
    if (!source.warning.empty()) RCLCPP_WARN(get_logger(), "%s", source.warning.c_str());
    if (!source.scanner) throw Error("no scanner is known; set the parameter 'scanner'");
    const EngineSetup setup{completed(*source.scanner, source.scanner_name,
                                      source.frames->format().size, source.sequence.projector),
                            source.sequence};
    require_ambient_known(setup, source.scanner_name);

    publisher_ = std::make_unique<Publisher>();
    PublishedRun run{.camera = setup.scanner.camera, .frame_id = text("frame_id")};
    publisher_->add("ROS", std::make_unique<NodeSink>(*this, std::move(run)));
    LiveSettings settings;
    settings.held_clouds += Publisher::held_clouds;
    settings.on_cloud = [this](const auto& cloud) { publisher_->publish(cloud); };
    pipeline_ = std::make_unique<LivePipeline>(std::move(source.frames), setup, settings);
    capture_ = service("capture", &ScannerNode::capture);
    check_ = service("check", &ScannerNode::check);
  }

  void start() { pipeline_->start(); }
  void stop() { pipeline_->stop(); }  // may be started again

  void forget() {
    capture_.reset();
    check_.reset();
    if (pipeline_) pipeline_->stop();
    publisher_.reset();
    pipeline_.reset();
  }

  rclcpp::Service<Trigger>::SharedPtr service(const std::string& name,
                                              std::string (ScannerNode::*answer)()) {
    return create_service<Trigger>("~/" + name,
                                   [this, answer](const std::shared_ptr<Trigger::Request>,
                                                  std::shared_ptr<Trigger::Response> response) {
                                     try {
                                       response->message = (this->*answer)();
                                       response->success = true;
                                     } catch (const std::exception& error) {
                                       response->message = error.what();
                                     }
                                   });
  }

  /// Writes the newest cloud and returns its path.
  std::string capture() {
    const auto newest = pipeline_->newest();
    if (!newest) throw Error("no cloud to save yet");
    const auto file = path_named_by_time(text("save_to"), "cloud", ".ply");

    // Another node may save to the same folder: whoever creates the file has its name.
    std::FILE* const created = std::fopen(file.c_str(), "wx");
    if (created == nullptr && errno == EEXIST) throw Error(file.string() + " was just taken");
    if (created != nullptr) std::fclose(created);

    write_cloud(file, newest->cloud);
    return file.string();
  }

  std::string check() {
    const LiveStatistics now = pipeline_->statistics();
    std::string problems = now.source_state;
    for (const auto& finding : now.findings)
      problems += (problems.empty() ? "" : "; ") + finding.what;
    if (!problems.empty()) throw Error(problems);
    return "OK: no problems found";
  }

  std::unique_ptr<Publisher> publisher_;
  std::unique_ptr<LivePipeline> pipeline_;
  rclcpp::Service<Trigger>::SharedPtr capture_, check_;
};

}  // namespace slipstream_ros

RCLCPP_COMPONENTS_REGISTER_NODE(slipstream_ros::ScannerNode)
