// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <string>
#include <string_view>

#include "drivers/ros2/ros2_node.h"

namespace facet {
namespace {

constexpr std::size_t kLongestTopic = 200;  // DDS allows 256, with rt/ before it
constexpr std::string_view kCompressed = "/compressed";

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

const char* topic_fault(std::string_view topic) {
    if (topic.empty() || topic.front() != '/') {
        return "must begin with /";
    }
    if (topic.size() > kLongestTopic) {
        return "is too long";
    }
    for (std::size_t i = 0; i < topic.size(); ++i) {
        const bool begins_part = i > 0 && topic[i - 1] == '/';
        if (topic[i] == '/' ? i + 1 == topic.size() || begins_part
                            : !is_letter(topic[i]) && !(is_digit(topic[i]) && !begins_part)) {
            return "must consist of parts such as /camera/infra1: letters, digits and _, no digit first";
        }
    }
    return nullptr;
}

std::string camera_info_topic(const std::string& image_topic) {
    std::string_view topic = image_topic;
    if (topic.ends_with(kCompressed)) {
        topic.remove_suffix(kCompressed.size());
    }
    return std::string(topic.substr(0, topic.rfind('/'))) + "/camera_info";
}

}  // namespace facet
