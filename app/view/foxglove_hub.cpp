// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/foxglove_hub.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/output/frame_log.h"
#include "app/view/picture_message.h"

namespace facet {
namespace {

using nlohmann::json;

/// The session is new with each start of the program: clients then forget what they have.
std::string greeting_text() {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return json{{"op", "serverInfo"},         {"name", "facet"},
                {"capabilities", {"time"}},   {"supportedEncodings", {kFoxgloveEncoding}},
                {"metadata", json::object()}, {"sessionId", std::to_string(std::chrono::nanoseconds(now).count())}}
        .dump();
}

std::string channels_text() {
    json channels = json::array();
    for (const FoxgloveTopicInfo& topic : kFoxgloveTopicInfos) {
        channels.push_back({{"id", channels.size() + 1},
                            {"topic", topic.name},
                            {"encoding", kFoxgloveEncoding},
                            {"schemaName", schema_name(topic.schema)},
                            {"schema", schema_text(topic.schema)},
                            {"schemaEncoding", kFoxgloveSchemaEncoding}});
    }
    return json{{"op", "advertise"}, {"channels", std::move(channels)}}.dump();
}

SharedFoxgloveMessage make_message(FoxgloveTopic topic, Timestamp stamp, std::string body) {
    return std::make_shared<const FoxgloveMessage>(FoxgloveMessage{topic, stamp, std::move(body)});
}

}  // namespace

FoxgloveHub::FoxgloveHub() : greeting_(greeting_text()), channels_(channels_text()) {}

void FoxgloveHub::adopt(FoxgloveClient::Stream stream, FoxgloveClient::Request request) {
    const auto client = std::make_shared<FoxgloveClient>(std::move(stream), std::move(request), *this);
    clients_.push_back(client);
    client->start();
}

std::size_t FoxgloveHub::clients() {
    std::erase_if(clients_, [](const std::weak_ptr<FoxgloveClient>& client) { return client.expired(); });
    return clients_.size();
}

void FoxgloveHub::take(const ViewSnapshot& snapshot) {
    for (const ViewState& state : snapshot.states) {
        if (state.is_keyframe && state.has_pose) {
            extend_path(state);
        }
        give_state(state);
    }
    if (snapshot.mesh_stamp) {
        mesh_ = snapshot.mesh;
        renew(FoxgloveTopic::kMesh, *snapshot.mesh_stamp);
        renew(FoxgloveTopic::kPlanes, *snapshot.mesh_stamp);
    }
    if (snapshot.picture_stamp) {
        picture_ = snapshot.picture;
        renew(FoxgloveTopic::kImage, *snapshot.picture_stamp);
    }
    if (snapshot.calibration_stamp) {
        calibration_ = snapshot.calibration;
        renew(FoxgloveTopic::kCalibration, *snapshot.calibration_stamp);
    }
}

void FoxgloveHub::extend_path(const ViewState& state) {
    path_.add(state);
    T_B_C_ = state.T_B_C;
    renew(FoxgloveTopic::kTransforms, state.stamp);
    renew(FoxgloveTopic::kPath, state.stamp);
}

/// What every frame has of its own.
void FoxgloveHub::give_state(const ViewState& state) {
    for (const std::weak_ptr<FoxgloveClient>& known : clients_) {
        if (const auto client = known.lock()) {
            client->push_time(state.stamp);
        }
    }
    const auto give_if_wanted = [&](FoxgloveTopic topic, auto make) {
        if (wants(topic)) {
            give(make_message(topic, state.stamp, make()));
        }
    };
    if (state.has_pose) {
        give_if_wanted(FoxgloveTopic::kPose, [&] { return pose_message(state.stamp, kWorldFrame, state.T_W_B); });
        give_if_wanted(FoxgloveTopic::kTransforms,
                       [&] { return transform_message(state.stamp, kWorldFrame, kBodyFrame, state.T_W_B); });
    }
    give_if_wanted(FoxgloveTopic::kHealth,
                   [&] { return health_message(state.stamp, state.health, reason_names(state.health.reasons)); });
    give_if_wanted(FoxgloveTopic::kTiming, [&] { return timing_message(state.stamp, state.is_keyframe, state.times); });
}

void FoxgloveHub::give(const SharedFoxgloveMessage& message) {
    for (const std::weak_ptr<FoxgloveClient>& known : clients_) {
        if (const auto client = known.lock()) {
            client->push(message);
        }
    }
}

/// What is known of the topic has changed.
void FoxgloveHub::renew(FoxgloveTopic topic, Timestamp stamp) {
    known_[place(topic)] = stamp;
    messages_[place(topic)] = nullptr;
    if (wants(topic)) {
        give(newest(topic));
    }
}

SharedFoxgloveMessage FoxgloveHub::newest(FoxgloveTopic topic) {
    const std::optional<Timestamp> stamp = known_[place(topic)];
    SharedFoxgloveMessage& message = messages_[place(topic)];
    if (stamp && !message) {
        message = make_message(topic, *stamp, encode(topic, *stamp));
    }
    return message;
}

std::string FoxgloveHub::encode(FoxgloveTopic topic, Timestamp stamp) const {
    switch (topic) {
        case FoxgloveTopic::kPath: return path_message(stamp, kWorldFrame, path_.poses());
        case FoxgloveTopic::kTransforms: return transform_message(stamp, kBodyFrame, kCameraFrame, T_B_C_);
        case FoxgloveTopic::kMesh: return mesh_scene(stamp, kWorldFrame, mesh_.faces);
        case FoxgloveTopic::kPlanes: return planes_scene(stamp, kWorldFrame, mesh_.planes);
        case FoxgloveTopic::kImage: return picture_image_message(stamp, picture_);
        case FoxgloveTopic::kCalibration: return calibration_message(stamp, calibration_);
        case FoxgloveTopic::kPose:
        case FoxgloveTopic::kHealth:
        case FoxgloveTopic::kTiming:
        case FoxgloveTopic::kCount: break;  // of a frame alone
    }
    return "";
}

}  // namespace facet
