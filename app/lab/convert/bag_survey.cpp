// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/bag_survey.h"

#include <algorithm>
#include <memory>

#include "app/lab/convert/grey_image.h"
#include "drivers/replay_asl/image_decoder.h"

namespace facet {
namespace {

/// tf names were absolute once.
std::string frame_of(std::string_view name) { return std::string(name.starts_with('/') ? name.substr(1) : name); }

class Surveyor {
public:
    explicit Surveyor(BagSurvey& survey) : survey_(survey) {}

    void add(const BagMessage& message, RosKind kind) {
        switch (kind) {
            case RosKind::kCameraInfo: add_lens(message); return;
            case RosKind::kTransforms: add_transforms(message); return;
            default: break;
        }
        TopicSurvey& topic = survey_.topics[message.topic->name];
        topic.kind = kind;
        topic.type = message.topic->type;
        ++topic.count;
        switch (kind) {
            case RosKind::kImu: add_imu(message, topic); break;
            case RosKind::kPose: add_pose(message, topic); break;
            default: add_image(message, topic); break;
        }
    }

private:
    static void note_stamp(const BagMessage& message, std::int64_t stamp_ns, TopicSurvey& topic) {
        if (stamp_ns <= 0) {
            return;
        }
        topic.first_ns = topic.first_ns == 0 ? stamp_ns : std::min(topic.first_ns, stamp_ns);
        topic.last_ns = std::max(topic.last_ns, stamp_ns);
        topic.least_delay_ns = std::min(topic.least_delay_ns, static_cast<std::int64_t>(message.time_ns) - stamp_ns);
    }
    static void add_imu(const BagMessage& message, TopicSurvey& topic) {
        RosImu imu;
        if (!read_message(message, imu)) {
            return;
        }
        const auto is_set = [](double x) { return x != 0.0; };
        topic.has_rates = topic.has_rates || std::any_of(imu.values.begin(), imu.values.begin() + 3, is_set);
        topic.has_forces = topic.has_forces || std::any_of(imu.values.begin() + 3, imu.values.end(), is_set);
        topic.frame = topic.frame.empty() ? frame_of(imu.frame) : topic.frame;
        note_stamp(message, imu.stamp_ns, topic);
    }
    static void add_pose(const BagMessage& message, TopicSurvey& topic) {
        if (RosPose pose; read_message(message, pose)) {
            note_stamp(message, pose.stamp_ns, topic);
        }
    }
    /// Of the first image that can be decoded.
    void find_size(const RosImage& image, TopicSurvey& topic) {
        if (topic.width == 0 && ok(decoder_.decode(image.data, 0, 0, grey_))) {
            topic.width = static_cast<std::uint32_t>(grey_.width);
            topic.height = static_cast<std::uint32_t>(grey_.height);
        }
    }
    void add_image(const BagMessage& message, TopicSurvey& topic) {
        RosImage image;
        if (!read_message(message, image)) {
            return;
        }
        if (topic.kind == RosKind::kCompressedImage) {
            find_size(image, topic);
        }
        topic.greatest_sample = std::max(topic.greatest_sample, greatest_wide_sample(image));
        if (topic.encoding.empty()) {
            topic.frame = frame_of(image.frame);
            topic.encoding = std::string(image.encoding.substr(0, 40));
            topic.width = topic.width > 0 ? topic.width : image.width;
            topic.height = topic.height > 0 ? topic.height : image.height;
        }
        note_stamp(message, image.stamp_ns, topic);
    }
    void add_lens(const BagMessage& message) {
        RosCameraInfo info;
        if (!survey_.lenses.contains(message.topic->name) && read_message(message, info)) {
            survey_.lenses[message.topic->name] = {frame_of(info.frame),
                                                   info.width,
                                                   info.height,
                                                   std::string(info.distortion_model),
                                                   info.d,
                                                   info.k,
                                                   info.p};
        }
    }
    void add_transforms(const BagMessage& message) {
        if (!message.topic->name.ends_with("tf_static") || !read_message(message, transforms_)) {
            return;
        }
        for (const RosTransform& t : transforms_) {
            survey_.transforms.push_back({frame_of(t.parent), frame_of(t.child), t.values});
        }
    }

    BagSurvey& survey_;
    ImageDecoder decoder_;
    GreyImage grey_;
    std::vector<RosTransform> transforms_;
};

}  // namespace

BagSurvey survey_bag(const std::string& path, const Bag::Warn& warn, const std::function<void(double)>& progress,
                     const std::atomic<bool>& stop) {
    const std::unique_ptr<Bag> bag = open_bag(path, warn, &stop);
    BagSurvey survey;
    Surveyor surveyor(survey);
    for (BagMessage message; !stop.load() && bag->next(message);) {
        if (const std::optional<RosKind> kind = kind_of(message.topic->type)) {
            surveyor.add(message, *kind);
        }
        progress(bag->share());
    }
    return survey;
}

}  // namespace facet
