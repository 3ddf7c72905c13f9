// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/video_file.h"

#include <algorithm>

#include "app/support/input_error.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/pixdesc.h>
}

namespace facet {

struct LibavDeleter {
    void operator()(AVFormatContext* input) const { avformat_close_input(&input); }
    void operator()(AVCodecContext* decoder) const { avcodec_free_context(&decoder); }
    void operator()(AVPacket* packet) const { av_packet_free(&packet); }
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};

namespace {

template <class T>
using LibavOwner = std::unique_ptr<T, LibavDeleter>;

/// A file whose one stream of interest is its first video track. @return nullptr if it has none
LibavOwner<AVFormatContext> open_input(const std::string& path, int& track) {
    av_log_set_level(AV_LOG_QUIET);
    AVFormatContext* opened = nullptr;
    // A file, never an address: "tcp:..." would be one.
    if (avformat_open_input(&opened, ("file:" + path).c_str(), nullptr, nullptr) < 0) {
        return nullptr;
    }
    LibavOwner<AVFormatContext> input(opened);
    if (avformat_find_stream_info(opened, nullptr) < 0) {
        return nullptr;
    }
    track = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
    if (track < 0) {
        return nullptr;
    }
    for (unsigned i = 0; i < opened->nb_streams; ++i) {
        opened->streams[i]->discard = static_cast<int>(i) == track ? AVDISCARD_DEFAULT : AVDISCARD_ALL;
    }
    return input;
}

/// One component of all pixels as 8 bits.
void read_component(const AVFrame& frame, const AVPixFmtDescriptor& format, int component, GreyImage& to) {
    const int depth = format.comp[component].depth;
    std::vector<std::uint16_t> row(static_cast<std::size_t>(frame.width));
    const std::uint8_t* planes[4] = {frame.data[0], frame.data[1], frame.data[2], frame.data[3]};
    const int strides[4] = {frame.linesize[0], frame.linesize[1], frame.linesize[2], frame.linesize[3]};
    for (int v = 0; v < frame.height; ++v) {
        av_read_image_line2(row.data(), planes, strides, &format, 0, v, component, frame.width, 0, sizeof(row[0]));
        std::ranges::transform(row, to.pixels.begin() + std::ptrdiff_t{v} * frame.width, [depth](std::uint16_t sample) {
            return static_cast<std::uint8_t>(depth > 8 ? sample >> (depth - 8) : sample << (8 - depth));
        });
    }
}

/// @return false if the frame's pixels are of a kind that has no luma or colours to read
bool grey_of(const AVFrame& frame, GreyImage& grey) {
    const AVPixFmtDescriptor* const format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
    constexpr std::uint64_t kUnread = AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_FLOAT |
                                      AV_PIX_FMT_FLAG_BAYER | AV_PIX_FMT_FLAG_BITSTREAM;
    if (format == nullptr || (format->flags & kUnread) != 0 || frame.width <= 0 || frame.height <= 0 ||
        frame.width > static_cast<int>(kMostPixelsAside) || frame.height > static_cast<int>(kMostPixelsAside)) {
        return false;
    }
    grey.resize(frame.width, frame.height);
    read_component(frame, *format, 0, grey);
    if ((format->flags & AV_PIX_FMT_FLAG_RGB) != 0 && format->nb_components >= 3) {
        GreyImage green = grey;
        GreyImage blue = grey;
        read_component(frame, *format, 1, green);
        read_component(frame, *format, 2, blue);
        for (std::size_t i = 0; i < grey.pixels.size(); ++i) {
            grey.pixels[i] = luma(grey.pixels[i], green.pixels[i], blue.pixels[i]);
        }
    }
    return true;
}

}  // namespace

struct VideoFile::Streams {
    explicit Streams(const std::string& path);

    bool next_frame();

    int track = -1;
    std::unique_ptr<AVFormatContext, LibavDeleter> input;
    std::unique_ptr<AVCodecContext, LibavDeleter> decoder;
    std::unique_ptr<AVPacket, LibavDeleter> packet{av_packet_alloc()};
    std::unique_ptr<AVFrame, LibavDeleter> frame{av_frame_alloc()};
    std::vector<std::int64_t> ticks;  ///< stamps in the track's unit, in order
    std::vector<std::int64_t> stamps_ns;
    bool has_stamps = true;
    bool is_at_end = false;
    std::size_t decoded = 0;
};

VideoFile::Streams::Streams(const std::string& path) : input(open_input(path, track)) {
    if (input == nullptr) {
        throw InputError(path + ": is not a video file that libavformat reads");
    }
    while (av_read_frame(input.get(), packet.get()) >= 0) {
        if (packet->stream_index == track && (packet->flags & AV_PKT_FLAG_DISCARD) == 0) {
            has_stamps = has_stamps && packet->pts != AV_NOPTS_VALUE;
            ticks.push_back(packet->pts);
        }
        av_packet_unref(packet.get());
    }
    std::ranges::sort(ticks);
    const AVRational unit = input->streams[track]->time_base;
    for (const std::int64_t tick : ticks) {
        stamps_ns.push_back(has_stamps ? av_rescale_q(tick, unit, {1, 1'000'000'000}) : 0);
    }
    input = open_input(path, track);
    const AVCodecParameters* const coding = input == nullptr ? nullptr : input->streams[track]->codecpar;
    const AVCodec* const codec = coding == nullptr ? nullptr : avcodec_find_decoder(coding->codec_id);
    decoder.reset(codec == nullptr ? nullptr : avcodec_alloc_context3(codec));
    if (decoder == nullptr || avcodec_parameters_to_context(decoder.get(), coding) < 0) {
        throw InputError(path + ": libavcodec cannot decode its video");
    }
    decoder->pkt_timebase = unit;
    if (avcodec_open2(decoder.get(), codec, nullptr) < 0) {
        throw InputError(path + ": libavcodec cannot decode its video");
    }
}

/// @return false at the end; damaged packets are skipped
bool VideoFile::Streams::next_frame() {
    for (;;) {
        const int result = avcodec_receive_frame(decoder.get(), frame.get());
        if (result == 0) {
            return true;
        }
        if (result == AVERROR_EOF || (is_at_end && result == AVERROR(EAGAIN))) {
            return false;
        }
        if (av_read_frame(input.get(), packet.get()) < 0) {
            is_at_end = true;
            static_cast<void>(avcodec_send_packet(decoder.get(), nullptr));
            continue;
        }
        if (packet->stream_index == track) {
            static_cast<void>(avcodec_send_packet(decoder.get(), packet.get()));
        }
        av_packet_unref(packet.get());
    }
}

bool VideoFile::is_built_in() { return true; }

bool VideoFile::recognises(const std::string& path) {
    int track = -1;
    return open_input(path, track) != nullptr;
}

VideoFile::VideoFile(const std::string& path) : streams_(std::make_unique<Streams>(path)) {}
VideoFile::~VideoFile() = default;

const std::vector<std::int64_t>& VideoFile::stamps_ns() const { return streams_->stamps_ns; }
bool VideoFile::has_stamps() const { return streams_->has_stamps; }

bool VideoFile::next(std::size_t& number, GreyImage& grey) {
    Streams& s = *streams_;
    while (s.next_frame()) {
        const bool is_usable = (s.frame->flags & AV_FRAME_FLAG_CORRUPT) == 0 && grey_of(*s.frame, grey);
        const std::int64_t tick = s.frame->best_effort_timestamp;
        number = s.decoded++;
        if (s.has_stamps && tick != AV_NOPTS_VALUE) {
            number = static_cast<std::size_t>(std::ranges::lower_bound(s.ticks, tick) - s.ticks.begin());
        }
        av_frame_unref(s.frame.get());
        if (is_usable && number < s.ticks.size()) {
            return true;
        }
    }
    return false;
}

}  // namespace facet
