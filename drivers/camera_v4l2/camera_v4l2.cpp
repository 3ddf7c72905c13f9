// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/camera_v4l2.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "drivers/common/stamp_fault.h"

namespace facet {
namespace {

// Cached memory is read at a GB/s and more by the slowest processors in question, uncached memory at 0.1 to 0.2.
constexpr double kSlowBytesPerSecond = 3e8;
constexpr int kCopiesJudged = 20;  // the fastest counts: the others may have been interrupted

}  // namespace

CameraV4l2::CameraV4l2(KernelIo& io, const Clock& clock, CameraV4l2Options options, SharedExposure* automatic,
                       std::size_t camera)
    : options_(std::move(options)),
      clock_(clock),
      capture_(io),
      controls_(io),
      life_(*this, clock, options_.retry_period, counters_, options_.silence),
      automatic_(automatic),
      camera_(camera) {
    if (options_.capture.width > 0 && options_.capture.height > 0) {
        image_bytes_ =
            static_cast<std::size_t>(options_.capture.width) * static_cast<std::size_t>(options_.capture.height);
        pixels_ = std::make_unique<std::uint8_t[]>(image_bytes_ * kSlots);
    }
}

Status CameraV4l2::open(std::string& problem) {
    if (image_bytes_ == 0) {
        problem = options_.capture.device + ": width and height must be given";
        return Status::kInvalidArgument;
    }
    any_sequence_ = false;  // drivers count from zero again
    copies_ = 0;
    FACET_TRY(capture_.prepare(options_.capture, problem));
    if (capture_.format() == PixelFormat::kMjpg && !jpeg_) {
        jpeg_ = std::make_unique<MjpegDecoder>(options_.capture.width, options_.capture.height);
    }
    FACET_TRY(set_controls(problem));
    return capture_.start(problem);
}

/// Before streaming: many sensors take some of them only then, and the first image is exposed as it should be.
Status CameraV4l2::set_controls(std::string& problem) {
    warning_ = capture_.warning();
    if (options_.controls_device.empty()) {
        controls_.borrow(capture_.descriptor(), options_.capture.device);
    } else {
        FACET_TRY(controls_.open(options_.controls_device, problem));
    }
    for (const CameraControl& control : options_.controls) {
        std::string words;
        const Status status = controls_.set(control.name, control.value, words);
        if (status == Status::kNotFound) {
            warning_ += (warning_.empty() ? "" : "; ") + words;
        } else if (!ok(status)) {
            problem = std::move(words);
            return status;
        }
    }
    if (automatic_ == nullptr) {
        return Status::kOk;
    }
    return prepare_exposure(problem);
}

/// Of the two controls everything is looked up here: while images come, a step is two system calls.
Status CameraV4l2::prepare_exposure(std::string& problem) {
    const AutoExposureOptions& options = automatic_->options();
    const ExposureSetting setting = automatic_->setting();
    FACET_TRY(controls_.find(options.exposure_control, exposure_control_, problem));
    FACET_TRY(controls_.find(options.gain_control, gain_control_, problem));
    FACET_TRY(controls_.set(options.exposure_control, setting.exposure, problem));
    FACET_TRY(controls_.set(options.gain_control, setting.gain, problem));
    exposures_.clear();
    note_exposure(setting, 0);
    return Status::kOk;
}

/// @param first_sequence  the first frame that is exposed so. @return whether the camera took it. No heap
bool CameraV4l2::set_exposure(const ExposureSetting& setting, std::uint32_t first_sequence) {
    if (controls_.write(exposure_control_, setting.exposure) < 0 || controls_.write(gain_control_, setting.gain) < 0) {
        return false;
    }
    note_exposure(setting, first_sequence);
    return true;
}

void CameraV4l2::note_exposure(const ExposureSetting& setting, std::uint32_t first_sequence) {
    set_ = setting;
    exposures_.add(first_sequence, Duration::from_seconds(setting.exposure * automatic_->options().exposure_step_s));
}

/// Shows the image to the rig, and takes over what it has decided. A refused setting is tried again at the next image.
void CameraV4l2::follow_exposure(const V4l2Buffer& buffer, const ImageView& image) {
    automatic_->add_image(camera_, image);
    const ExposureSetting wanted = automatic_->setting();
    if (wanted == set_) {
        return;
    }
    const auto latency = static_cast<std::uint32_t>(automatic_->options().latency_frames);
    const bool is_set = set_exposure(wanted, buffer.sequence + latency);
    ++(is_set ? camera_counters_.exposures_set : camera_counters_.exposures_refused);
}

void CameraV4l2::follow_sequence(std::uint32_t sequence) {
    // Some drivers leave the sequence at zero; a step backwards is a restart of the driver, not a gap.
    const auto step = static_cast<std::int32_t>(sequence - sequence_);
    if (any_sequence_ && step > 1) {
        counters_.lost += static_cast<std::uint64_t>(step - 1);
    }
    any_sequence_ = true;
    sequence_ = sequence;
}

bool CameraV4l2::is_good(const V4l2Buffer& buffer) {
    const std::size_t needed = capture_.least_bytes(options_.capture.width, options_.capture.height);
    camera_counters_.error_buffers += buffer.error ? 1 : 0;
    camera_counters_.short_buffers += !buffer.error && buffer.bytes.size() < needed ? 1 : 0;
    return !buffer.error && buffer.bytes.size() >= needed;
}

Status CameraV4l2::take_all(Duration timeout, V4l2Buffer& newest) {
    std::optional<V4l2Buffer> kept;
    bool bad = false;
    // No more rounds than there are buffers: a fast camera must not keep the caller here.
    for (std::uint32_t round = 0; round < V4l2Capture::kMaxBuffers; ++round) {
        V4l2Buffer buffer;
        std::string words;
        const Status status = capture_.dequeue(round == 0 ? timeout : Duration{}, buffer, words);
        if (status == Status::kNotReady) {
            break;
        }
        if (!ok(status)) {
            return life_.fail(std::move(words));
        }
        follow_sequence(buffer.sequence);
        const bool good = is_good(buffer);
        const std::optional<V4l2Buffer> back = good ? kept : std::optional<V4l2Buffer>(buffer);
        if (good) {
            counters_.discarded += kept ? 1 : 0;
            camera_counters_.superseded += kept ? 1 : 0;
            kept = buffer;
        } else {
            ++counters_.corrupt;
            life_.refuse(buffer.error ? "the driver marks every buffer as bad" : "every buffer is too short");
            bad = true;
        }
        if (back && !ok(capture_.queue(back->index, words))) {
            return life_.fail(std::move(words));
        }
    }
    if (!kept) {
        return bad ? Status::kCorrupt : Status::kNotReady;
    }
    newest = *kept;
    return Status::kOk;
}

/// Uncached buffers cost the reader's core milliseconds an image: whoever sets up the vehicle is told.
void CameraV4l2::judge_copy(Duration took, std::size_t bytes) {
    if (copies_ == kCopiesJudged) {
        return;
    }
    fastest_copy_ = copies_ == 0 ? took : std::min(fastest_copy_, took);
    ++copies_;
    if (copies_ == kCopiesJudged && static_cast<double>(bytes) < kSlowBytesPerSecond * fastest_copy_.seconds()) {
        warning_ += (warning_.empty() ? "" : "; ") + options_.capture.device + ": an image takes " +
                    std::to_string(fastest_copy_.ns / 1000) +
                    " us to copy out of its buffer, which is not cached: set cameras.heap";
    }
}

Timestamp CameraV4l2::midpoint(const V4l2Buffer& buffer, Duration exposure) const {
    const Duration half{exposure.ns / 2};
    StampSource source = options_.stamp_source;
    if (source == StampSource::kAsFlagged) {
        source = buffer.start_of_exposure ? StampSource::kStartOfExposure : StampSource::kEndOfFrame;
    }
    switch (source) {
        case StampSource::kStartOfExposure: return buffer.stamp + half;
        case StampSource::kEndOfFrame: return buffer.stamp - options_.readout - half;
        default: return buffer.stamp;
    }
}

Status CameraV4l2::to_grey(const V4l2Buffer& buffer, std::uint8_t* out) {
    if (capture_.format() == PixelFormat::kMjpg) {
        const Status decoded = jpeg_->decode(buffer.bytes, {out, image_bytes_});
        if (!ok(decoded)) {
            ++counters_.corrupt;
            ++camera_counters_.damaged;
            life_.refuse("every JPEG is damaged, or of another size");
        }
        return decoded;
    }
    const RawImage image{buffer.bytes,      capture_.format(),         options_.capture.width, options_.capture.height,
                         capture_.stride(), options_.significant_bits, options_.msb_aligned};
    const Timestamp begin = clock_.now();
    FACET_TRY(unpack(image, {out, image_bytes_}));
    judge_copy(clock_.now() - begin, buffer.bytes.size());
    return Status::kOk;
}

Status CameraV4l2::deliver(const V4l2Buffer& buffer, CameraFrame& frame) {
    camera_counters_.not_monotonic += buffer.monotonic ? 0 : 1;
    const Duration exposure = exposures_.at(buffer.sequence, options_.exposure);
    const Timestamp stamp = midpoint(buffer, exposure);
    const char* const fault = delivery_fault({buffer.stamp, stamp}, clock_, clock(), order_, counters_.discarded);
    if (fault != nullptr) {
        ++camera_counters_.stamps_refused;
        life_.refuse(fault);
        return Status::kNotReady;
    }
    SlotLease slot = slots_.take();
    if (!slot.held()) {
        ++counters_.discarded;
        ++camera_counters_.no_slot;
        life_.works();  // the camera is not to blame
        return Status::kNotReady;
    }
    std::uint8_t* const out = pixels_.get() + static_cast<std::size_t>(slot.slot()) * image_bytes_;
    FACET_TRY(to_grey(buffer, out));
    order_.delivered(stamp);
    frame.stamp = stamp;
    frame.sequence = buffer.sequence;
    frame.image = {out, options_.capture.width, options_.capture.height, options_.capture.width};
    frame.slot = std::move(slot);
    frame.exposure = exposure;
    if (automatic_ != nullptr) {
        follow_exposure(buffer, frame.image);
    }
    return Status::kOk;
}

Status CameraV4l2::take(Duration timeout, CameraFrame& frame) {
    V4l2Buffer newest;
    FACET_TRY(take_all(timeout, newest));
    const Status delivered = deliver(newest, frame);
    std::string words;
    if (!ok(capture_.queue(newest.index, words)) && !ok(delivered)) {
        return life_.fail(std::move(words));
    }
    // Queueing that fails after a good frame fails again in the next call, which then reports it.
    return delivered == Status::kInvalidArgument ? life_.fail(options_.capture.device + ": impossible image size")
                                                 : delivered;
}

Status CameraV4l2::next(Duration timeout, CameraFrame& frame) {
    return life_.next(options_.capture.device, [&] { return take(timeout, frame); });
}

}  // namespace facet
