// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/estimate_channels.h"

#include <algorithm>
#include <map>

#include "app/foxglove/messages.h"
#include "app/foxglove/scene.h"
#include "app/output/frame_log.h"
#include "app/view/picture_message.h"

namespace facet {

EstimateChannels::EstimateChannels(McapWriter& writer, bool has_pictures) : writer_(writer) {
    std::map<FoxgloveSchema, std::uint16_t> schemas;
    for (std::size_t topic = 0; topic < kFoxgloveTopics; ++topic) {
        const FoxgloveTopicInfo& info = kFoxgloveTopicInfos[topic];
        if (static_cast<FoxgloveTopic>(topic) == FoxgloveTopic::kImage && !has_pictures) {
            continue;
        }
        std::uint16_t& schema = schemas[info.schema];
        if (schema == 0) {
            schema = writer.add_schema(schema_name(info.schema), kFoxgloveSchemaEncoding, schema_text(info.schema));
        }
        channels_[topic] = writer.add_channel(schema, info.name, kFoxgloveEncoding, {});
    }
}

void EstimateChannels::write(FoxgloveTopic topic, Timestamp stamp, const std::string& message) {
    const std::uint16_t channel = channels_[static_cast<std::size_t>(topic)];
    if (channel != 0 && !message.empty()) {
        writer_.add_message(channel, static_cast<std::uint64_t>(std::max<std::int64_t>(stamp.ns, 0)), message);
    }
}

void EstimateChannels::add(const ViewState& state) {
    const Timestamp stamp = state.stamp;
    if (state.has_pose) {
        write(FoxgloveTopic::kPose, stamp, pose_message(stamp, kWorldFrame, state.T_W_B));
        write(FoxgloveTopic::kTransforms, stamp, transform_message(stamp, kWorldFrame, kBodyFrame, state.T_W_B));
    }
    write(FoxgloveTopic::kHealth, stamp, health_message(stamp, state.health, reason_names(state.health.reasons)));
    write(FoxgloveTopic::kTiming, stamp, timing_message(stamp, state.is_keyframe, state.times));
    if (!state.has_pose || !state.is_keyframe) {
        return;
    }
    path_.add(state);
    write(FoxgloveTopic::kTransforms, stamp, transform_message(stamp, kBodyFrame, kCameraFrame, state.T_B_C));
    if (stamp >= next_path_) {
        next_path_ = stamp + kPathPeriod;
        write(FoxgloveTopic::kPath, stamp, path_message(stamp, kWorldFrame, path_.poses()));
    }
}

void EstimateChannels::add(Timestamp stamp, const ViewMesh& mesh) {
    write(FoxgloveTopic::kMesh, stamp, mesh_scene(stamp, kWorldFrame, mesh.faces));
    write(FoxgloveTopic::kPlanes, stamp, planes_scene(stamp, kWorldFrame, mesh.planes));
}

void EstimateChannels::add(Timestamp stamp, const CalibrationEstimate& calibration) {
    write(FoxgloveTopic::kCalibration, stamp, calibration_message(stamp, calibration));
}

void EstimateChannels::add(Timestamp stamp, const ViewPicture& picture) {
    write(FoxgloveTopic::kImage, stamp, picture_image_message(stamp, picture));
}

}  // namespace facet
