// SPDX-License-Identifier: BSD-2-Clause
#include "app/foxglove/messages.h"

#include "app/foxglove/json_values.h"

namespace facet {
namespace {

using json_values::Json;

/// Base 64 [RFC 4648].
std::string base64(std::span<const std::uint8_t> bytes) {
    constexpr const char* kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            word = (word << 8U) | (i + k < bytes.size() ? bytes[i + k] : 0U);
        }
        const std::size_t letters = std::min<std::size_t>(bytes.size() - i, 3) + 1;
        for (std::size_t k = 0; k < 4; ++k) {
            out += k < letters ? kLetters[(word >> (18U - 6U * k)) & 63U] : '=';
        }
    }
    return out;
}

}  // namespace

std::string pose_message(Timestamp stamp, const char* frame, const Se3& T) {
    return Json{{"timestamp", json_values::stamp(stamp)}, {"frame_id", frame}, {"pose", json_values::pose(T)}}.dump();
}

std::string path_message(Timestamp stamp, const char* frame, std::span<const Se3> poses) {
    Json list = Json::array();
    for (const Se3& T : poses) {
        list.push_back(json_values::pose(T));
    }
    return Json{{"timestamp", json_values::stamp(stamp)}, {"frame_id", frame}, {"poses", std::move(list)}}.dump();
}

std::string transform_message(Timestamp stamp, const char* parent, const char* child, const Se3& T) {
    return Json{{"timestamp", json_values::stamp(stamp)},
                {"parent_frame_id", parent},
                {"child_frame_id", child},
                {"translation", json_values::vector(T.p)},
                {"rotation", json_values::quaternion(T.q)}}
        .dump();
}

std::string image_message(Timestamp stamp, const char* frame, std::span<const std::uint8_t> file, const char* format) {
    return Json{
        {"timestamp", json_values::stamp(stamp)}, {"frame_id", frame}, {"data", base64(file)}, {"format", format}}
        .dump();
}

}  // namespace facet
