// SPDX-License-Identifier: BSD-2-Clause
// Topics of ROS 2 by Fast DDS, an implementation of DDS that is not the program's, with messages that Fast CDR writes
// and reads field by field.
#pragma once

#include <fastcdr/Cdr.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/dds/core/policy/QosPolicies.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace facet::test {

namespace dds = eprosima::fastdds::dds;
using Bytes = std::vector<char>;

/// A message as it is on the wire, with its encapsulation.
class WireType final : public dds::TopicDataType {
public:
    explicit WireType(const std::string& name) {
        setName(name.c_str());
        m_typeSize = 1U << 16U;  // grows
        m_isGetKeyDefined = false;
        auto_fill_type_information(false);
        auto_fill_type_object(false);
    }
    bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
        const Bytes& bytes = *static_cast<Bytes*>(data);
        payload->reserve(static_cast<std::uint32_t>(bytes.size()));
        std::memcpy(payload->data, bytes.data(), bytes.size());
        payload->length = static_cast<std::uint32_t>(bytes.size());
        payload->encapsulation = CDR_LE;
        return true;
    }
    bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
        const auto* const begin = reinterpret_cast<const char*>(payload->data);
        static_cast<Bytes*>(data)->assign(begin, begin + payload->length);
        return true;
    }
    std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
        return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
    }
    void* createData() override { return new Bytes; }
    void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
    bool getKey(void* /*data*/, eprosima::fastrtps::rtps::InstanceHandle_t* /*key*/, bool /*md5*/) override {
        return false;
    }
};

/// Writes a message. @param write  void(Cdr&), its fields in order
template <class Write>
Bytes to_wire(std::size_t room, Write write) {
    Bytes bytes(room);
    eprosima::fastcdr::FastBuffer buffer(bytes.data(), bytes.size());
    eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::LITTLE_ENDIANNESS, eprosima::fastcdr::Cdr::DDS_CDR);
    cdr.serialize_encapsulation();
    write(cdr);
    bytes.resize(cdr.getSerializedDataLength());
    return bytes;
}

/// Reads a message, of which nothing may be left over. @param read  void(Cdr&), its fields in order
template <class Read>
void from_wire(Bytes& bytes, Read read) {
    constexpr std::size_t kPadding = 3;
    eprosima::fastcdr::FastBuffer buffer(bytes.data(), bytes.size());
    eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR);
    cdr.read_encapsulation();
    read(cdr);
    if (cdr.getSerializedDataLength() + kPadding < bytes.size()) {
        throw std::runtime_error("bytes are left over behind a message");
    }
}

/// A participant on the loopback interface. Thread-bound. Listeners are called on a thread of the middleware's.
class FastDds {
public:
    explicit FastDds(int domain) {
        dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
        auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
        udp->interfaceWhiteList.emplace_back("127.0.0.1");
        udp->sendBufferSize = udp->receiveBufferSize = 4U << 20U;
        qos.transport().use_builtin_transports = false;
        qos.transport().user_transports.push_back(udp);
        participant_ =
            dds::DomainParticipantFactory::get_instance()->create_participant(static_cast<std::uint32_t>(domain), qos);
        require(participant_ != nullptr, "participant");
        publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
        subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
    }
    ~FastDds() {
        participant_->delete_contained_entities();
        dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
    }
    FastDds(const FastDds&) = delete;
    FastDds& operator=(const FastDds&) = delete;

    dds::DataWriter* writer(const std::string& topic, const std::string& type, bool is_reliable) {
        dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
        set(qos, is_reliable);
        qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
        dds::DataWriter* const writer = publisher_->create_datawriter(make_topic(topic, type), qos);
        require(writer != nullptr, topic);
        return writer;
    }
    dds::DataReader* reader(const std::string& topic, const std::string& type, dds::DataReaderListener* listener) {
        dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
        set(qos, true);
        dds::DataReader* const reader = subscriber_->create_datareader(make_topic(topic, type), qos, listener);
        require(reader != nullptr, topic);
        return reader;
    }

private:
    static void require(bool is_true, const std::string& what) {
        if (!is_true) {
            throw std::runtime_error("Fast DDS refuses: " + what);
        }
    }
    template <class Qos>
    static void set(Qos& qos, bool is_reliable) {
        qos.reliability().kind = is_reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
        qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
        qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
        qos.history().depth = 100;
        qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    }
    dds::Topic* make_topic(const std::string& topic, const std::string& type) {
        const dds::TypeSupport support(new WireType(type));
        participant_->register_type(support);
        return participant_->create_topic("rt" + topic, type, dds::TOPIC_QOS_DEFAULT);
    }

    dds::DomainParticipant* participant_ = nullptr;
    dds::Publisher* publisher_ = nullptr;
    dds::Subscriber* subscriber_ = nullptr;
};

/// Hands over every message of a topic.
class WireListener final : public dds::DataReaderListener {
public:
    explicit WireListener(std::function<void(Bytes&)> hear) : hear_(std::move(hear)) {}
    void on_data_available(dds::DataReader* reader) override {
        Bytes bytes;
        dds::SampleInfo info;
        while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
            if (info.valid_data) {
                hear_(bytes);
            }
        }
    }

private:
    std::function<void(Bytes&)> hear_;
};

}  // namespace facet::test
