// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/cyclone_node.h"

#include <dds/ddsrt/log.h>

#include <algorithm>

namespace facet {
namespace {

constexpr dds_duration_t kWriterMayWait = DDS_MSECS(10);

/// Cyclone's first complaint while a domain is joined, for the problem; later ones are counted by the readers.
void keep_first(void* text, const dds_log_data_t* log) {
    if (auto* const first = static_cast<std::string*>(text); first != nullptr && first->empty()) {
        first->assign(log->message, log->size);
        first->erase(std::remove(first->begin(), first->end(), '\n'), first->end());
    }
}

void keep_first_in(std::string* text) {
    dds_set_log_sink(keep_first, text);
    dds_set_trace_sink(keep_first, nullptr);
}

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
    }
    return result;
}

/// On the loopback interface, which has no multicast on most systems, participants are found by asking for them.
std::string configuration(const Ros2NodeOptions& options) {
    std::string interfaces;
    std::string peers;
    bool is_loopback_only = true;
    for (const std::string& name : options.interfaces) {
        interfaces += "<NetworkInterface name=\"" + escaped(name) + "\"/>";
        peers += name == "lo" ? "<Peer address=\"127.0.0.1\"/>" : "";
        is_loopback_only = is_loopback_only && name == "lo";
    }
    for (const std::string& peer : options.peers) {
        peers += "<Peer address=\"" + escaped(peer) + "\"/>";
    }
    return "<General><Interfaces>" + interfaces + "</Interfaces><AllowMulticast>" +
           (is_loopback_only ? "false" : "default") +
           "</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
           "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers>" +
           peers +
           "</Peers></Discovery><SharedMemory><Enable>false</Enable></SharedMemory>"
           "<Internal><SocketReceiveBufferSize max=\"8MiB\"/></Internal>";
}

dds_qos_t* make_qos(const CycloneQos& options) {
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, options.is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                         kWriterMayWait);
    dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, options.depth);
    return qos;
}

}  // namespace

Status CycloneNode::open(std::string& problem) {
    const std::lock_guard lock(mutex_);
    if (participant_.is_set()) {
        return Status::kOk;
    }
    std::string first;
    keep_first_in(&first);
    const auto domain = static_cast<dds_domainid_t>(options_.domain);
    const bool is_joined = domain_.set(dds_create_domain(domain, configuration(options_).c_str())) &&
                           participant_.set(dds_create_participant(domain, nullptr, nullptr));
    keep_first_in(nullptr);
    if (!is_joined) {
        domain_.reset();
        participant_.set(0);
        problem = "ROS 2: the domain cannot be joined: " + (first.empty() ? "Cyclone DDS refuses" : first);
        return Status::kIo;
    }
    return Status::kOk;
}

dds_entity_t CycloneNode::make_topic(const std::string& ros_topic, const dds_topic_descriptor_t& type) const {
    return dds_create_topic(participant(), &type, ("rt" + ros_topic).c_str(), nullptr, nullptr);
}

dds_entity_t CycloneNode::make_reader(dds_entity_t topic, const CycloneQos& options) const {
    dds_qos_t* const qos = make_qos(options);
    const dds_entity_t reader = dds_create_reader(participant(), topic, qos, nullptr);
    dds_delete_qos(qos);
    return reader;
}

dds_entity_t CycloneNode::make_writer(dds_entity_t topic, const CycloneQos& options) const {
    dds_qos_t* const qos = make_qos(options);
    const dds_entity_t writer = dds_create_writer(participant(), topic, qos, nullptr);
    dds_delete_qos(qos);
    return writer;
}

}  // namespace facet

/// See Ros2ModuleMake.
extern "C" [[gnu::visibility("default")]] facet::Ros2Node* facet_make_ros2_node(const facet::Ros2NodeOptions& options) {
    return new facet::CycloneNode(options);
}
