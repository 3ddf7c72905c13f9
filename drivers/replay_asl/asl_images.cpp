// SPDX-License-Identifier: BSD-2-Clause
// The part of AslDataset that reads images, at once or ahead of time.
#include <array>
#include <memory>

#include "drivers/replay_asl/asl_dataset.h"

namespace facet {

Status AslDataset::decode(const std::string& path, const ImageSize& size, GreyImage& image) {
    if (options_.files == nullptr) {
        return decoder_.decode(path, size.width, size.height, image);
    }
    unread_ = options_.files->read(path, ImageDecoder::kMostBytes, file_);
    return unread_.empty() ? decoder_.decode(file_, size.width, size.height, image) : Status::kNotFound;
}

std::string AslDataset::image_path(const std::optional<ImageRow>& row, int camera) const {
    if (!row.has_value()) {
        return {};
    }
    const std::string& csv = camera_csv_[static_cast<std::size_t>(camera)];
    return csv.substr(0, csv.rfind('/') + 1) + "data/" + row->file;
}

bool AslDataset::load_image(const std::optional<ImageRow>& row, int camera, GreyImage& image) {
    if (!row.has_value()) {
        return false;
    }
    ImageSize& size = camera == 0 ? options_.left_size : options_.right_size;
    const Status status = decode(image_path(row, camera), size, image);
    if (ok(status)) {
        size = {image.width, image.height};
    }
    const bool is_unread = status == Status::kNotFound && options_.files != nullptr;
    return judge_image(status, is_unread ? unread_ : decoder_.error(), *row, camera);
}

bool AslDataset::judge_image(Status status, const std::string& error, const ImageRow& row, int camera) const {
    if (ok(status)) {
        return true;
    }
    const AslWarningKind kind = status == Status::kNotFound          ? AslWarningKind::kMissingFile
                                : status == Status::kInvalidArgument ? AslWarningKind::kWrongSize
                                                                     : AslWarningKind::kCorruptImage;
    const char* consequence = camera == 0 ? "; frame has a right view at most" : "; frame has a left view at most";
    warn(kind, camera_csv_[static_cast<std::size_t>(camera)], row.line,
         image_path(row, camera) + ": " + error + consequence);
    return false;
}

bool AslDataset::load_frame(std::size_t number, StereoFrame& frame) {
    const Pair& chosen = pair(number);
    frame = {pair_stamp(number), {}, {}};
    if (!options_.decode_images) {
        return true;
    }
    if (options_.decode_ahead && options_.files == nullptr) {
        return load_frame_ahead(number, frame);
    }
    const bool has_left = load_image(chosen.left, 0, images_[0]);
    const bool has_right = load_image(chosen.right, 1, images_[1]);
    if (!has_left && !has_right) {
        return false;
    }
    frame.left = has_left ? images_[0].view() : ImageView{};
    frame.right = has_right ? images_[1].view() : ImageView{};
    return true;
}

/// Frames come one after the other once the first has been given: those that precede the inertial data are skipped
/// before it.
bool AslDataset::load_frame_ahead(std::size_t number, StereoFrame& frame) {
    if (!ahead_) {
        const ImageSize& left = options_.left_size;
        const ImageSize& right = options_.right_size;
        ahead_ = std::make_unique<DecodeAhead>(
            std::array<WantedSize, 2>{{{left.width, left.height}, {right.width, right.height}}});
        next_asked_ = number;
        ask_ahead();
    }
    const DecodeAhead::Frame& images = ahead_->take();
    ask_ahead();
    const Pair& chosen = pair(number);
    const auto view = [&](const std::optional<ImageRow>& row, int camera) {
        const DecodeAhead::Image& image = images[static_cast<std::size_t>(camera)];
        return row.has_value() && judge_image(image.status, image.error, *row, camera) ? image.grey.view()
                                                                                       : ImageView{};
    };
    frame.left = view(chosen.left, 0);
    frame.right = view(chosen.right, 1);
    return !frame.left.empty() || !frame.right.empty();
}

void AslDataset::ask_ahead() {
    for (; next_asked_ < frame_count() && ahead_->has_room(); ++next_asked_) {
        const Pair& asked = pair(next_asked_);
        ahead_->ask({image_path(asked.left, 0), image_path(asked.right, 1)});
    }
}

}  // namespace facet
