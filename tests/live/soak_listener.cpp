// soak_listener NAMESPACE MILLISECONDS: a ROS 2 subscriber of a namespace's clouds and pictures
// that pauses so long after each; until killed.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include <dds/dds.h>

#include "ros2_messages.h"

int main(int, char** given) {
  const std::chrono::milliseconds pause(std::atoi(given[2]));
  const char* const domain = std::getenv("ROS_DOMAIN_ID");
  const dds_entity_t participant = dds_create_participant(
      static_cast<dds_domainid_t>(std::atoi(domain == nullptr ? "0" : domain)), nullptr, nullptr);
  const auto reader = [&](const dds_topic_descriptor_t& type, const std::string& name) {
    const std::string topic = std::string("rt/") + given[1] + "/" + name;
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 5);
    const auto made = dds_create_reader(
        participant, dds_create_topic(participant, &type, topic.c_str(), nullptr, nullptr), qos,
        nullptr);
    dds_delete_qos(qos);
    return made;
  };
  const dds_entity_t readers[] = {reader(sensor_msgs_msg_dds__PointCloud2__desc, "points"),
                                  reader(sensor_msgs_msg_dds__Image__desc, "image")};
  for (long messages = 0; true; std::this_thread::sleep_for(pause)) {
    for (const dds_entity_t from : readers) {
      void* sample = nullptr;
      dds_sample_info_t info;
      if (dds_take(from, &sample, &info, 1, 1) != 1) continue;
      dds_return_loan(from, &sample, 1);
      if (++messages % 1000 == 1) std::printf("%ld messages\n", messages), std::fflush(stdout);
    }
  }
}
