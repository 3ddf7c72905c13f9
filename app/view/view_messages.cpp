// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/view_messages.h"

#include <fmt/core.h>

#include <bit>
#include <utility>

#include "app/output/frame_log.h"

namespace facet {
namespace {

SharedMessage text_message(std::string body) {
    return std::make_shared<const ViewMessage>(ViewMessage{false, std::move(body)});
}

/// A binary message, written value by value.
class BinaryMessage {
public:
    BinaryMessage(ViewMessageKind kind, std::size_t bytes) {
        message_->is_binary = true;
        message_->body.reserve(4 + bytes);
        add(static_cast<std::int32_t>(kind));
    }
    void add(std::int32_t value) {
        const auto word = static_cast<std::uint32_t>(value);
        for (int shift = 0; shift < 32; shift += 8) {
            message_->body.push_back(static_cast<char>((word >> shift) & 0xffU));
        }
    }
    void add(float value) { add(std::bit_cast<std::int32_t>(value)); }
    void add(const std::string& bytes) { message_->body += bytes; }
    void add(const std::vector<std::uint8_t>& bytes) { message_->body.append(bytes.begin(), bytes.end()); }
    SharedMessage take() { return std::move(message_); }

private:
    std::shared_ptr<ViewMessage> message_ = std::make_shared<ViewMessage>();
};

std::string pose_text(const Se3& T) {
    return fmt::format(R"("p":[{:.4f},{:.4f},{:.4f}],"q":[{:.6f},{:.6f},{:.6f},{:.6f}],)", T.p.x(), T.p.y(), T.p.z(),
                       T.q.x(), T.q.y(), T.q.z(), T.q.w());
}

}  // namespace

SharedMessage hello_message(const StereoRig& rig) {
    const CameraIntrinsics& k = rig.left.intrinsics();
    const Se3& T = rig.T_B_C0;
    const double fx = k.fx > 0.0 ? k.fx : 1.0;
    const double fy = k.fy > 0.0 ? k.fy : 1.0;
    return text_message(fmt::format(R"({{"camera":{{"p":[{},{},{}],"q":[{},{},{},{}],"x":{},"y":{}}}}})", T.p.x(),
                                    T.p.y(), T.p.z(), T.q.x(), T.q.y(), T.q.z(), T.q.w(), k.cx / fx, k.cy / fy));
}

SharedMessage frame_message(const ViewState& s, Timestamp begin) {
    return text_message(fmt::format(
        R"({{"t":{:.4f},{}"state":"{}","reasons":"{}","quality":{},"tracked":{},"ms":{:.2f},"keyframe":{}}})",
        (s.stamp - begin).seconds(), s.has_pose ? pose_text(s.T_W_B) : "", to_string(s.health.state),
        reason_names(s.health.reasons), s.health.quality, s.health.tracked, s.times[0].wall_ms, s.is_keyframe));
}

SharedMessage mesh_message(const std::vector<ViewFace>& faces) {
    BinaryMessage message(ViewMessageKind::kMesh, 40 * faces.size());
    for (const ViewFace& face : faces) {
        for (const Eigen::Vector3f& p : face.p_W) {
            message.add(p.x());
            message.add(p.y());
            message.add(p.z());
        }
        message.add(face.plane);
    }
    return message.take();
}

SharedMessage picture_message(const ViewPicture& picture) {
    BinaryMessage message(ViewMessageKind::kPicture, 12 + 16 * picture.points.size() + picture.pixels.size());
    message.add(std::int32_t{picture.width});
    message.add(std::int32_t{picture.height});
    message.add(static_cast<std::int32_t>(picture.points.size()));
    for (const ViewPoint& point : picture.points) {
        message.add(point.px.x());
        message.add(point.px.y());
        message.add(point.depth_m);
        message.add(point.plane);
    }
    message.add(picture.pixels);
    return message.take();
}

SharedMessage surface_message(std::uint32_t surface, const std::string& pieces) {
    BinaryMessage message(ViewMessageKind::kSurface, 4 + pieces.size());
    message.add(static_cast<std::int32_t>(surface));
    message.add(pieces);
    return message.take();
}

}  // namespace facet
