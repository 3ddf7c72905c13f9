// SPDX-License-Identifier: BSD-2-Clause
#include "tests/app/lab/convert/test_video.h"

#include <catch2/catch.hpp>
#include <cstdint>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace facet::test {
namespace {

/// All components of a pixel alike, except that chroma stays in the middle.
void fill(AVFrame& frame, int k, const std::function<int(int k, int u, int v)>& grey) {
    const AVPixFmtDescriptor* const format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
    const bool is_rgb = (format->flags & AV_PIX_FMT_FLAG_RGB) != 0;
    for (int c = 0; c < format->nb_components; ++c) {
        const AVComponentDescriptor& component = format->comp[c];
        const bool is_chroma = !is_rgb && c > 0;
        const int width = is_chroma ? -((-frame.width) >> format->log2_chroma_w) : frame.width;
        const int height = is_chroma ? -((-frame.height) >> format->log2_chroma_h) : frame.height;
        for (int v = 0; v < height; ++v) {
            std::uint8_t* const row = frame.data[component.plane] + v * frame.linesize[component.plane];
            for (int u = 0; u < width; ++u) {
                const int value = (is_chroma ? 128 : grey(k, u, v)) << (component.depth - 8);
                std::uint8_t* const at = row + u * component.step + component.offset;
                at[0] = static_cast<std::uint8_t>(value);
                if (component.depth > 8) {
                    at[1] = static_cast<std::uint8_t>(value >> 8);
                }
            }
        }
    }
}

/// Packets that the encoder has ready.
void write_ready(AVFormatContext* output, AVCodecContext* encoder, AVPacket* packet) {
    while (avcodec_receive_packet(encoder, packet) == 0) {
        packet->duration = 1;  // without it MP4's table of edits cuts the last frame off
        av_packet_rescale_ts(packet, encoder->time_base, output->streams[0]->time_base);
        packet->stream_index = 0;
        REQUIRE(av_interleaved_write_frame(output, packet) == 0);
    }
}

}  // namespace

bool can_write_videos() { return true; }

void write_video(const std::string& path, const char* codec, const char* format, int width, int height, int frames,
                 const std::function<int(int k, int u, int v)>& grey) {
    av_log_set_level(AV_LOG_QUIET);
    AVFormatContext* output = nullptr;
    REQUIRE(avformat_alloc_output_context2(&output, nullptr, nullptr, path.c_str()) >= 0);
    const AVCodec* const coding = avcodec_find_encoder_by_name(codec);
    REQUIRE(coding != nullptr);
    AVCodecContext* encoder = avcodec_alloc_context3(coding);
    encoder->width = width;
    encoder->height = height;
    encoder->pix_fmt = av_get_pix_fmt(format);
    encoder->time_base = {1, 20};
    encoder->framerate = {20, 1};
    encoder->bit_rate = 4'000'000;
    encoder->global_quality = 2 * FF_QP2LAMBDA;
    encoder->flags |= AV_CODEC_FLAG_QSCALE;
    encoder->max_b_frames = std::string(codec) == "mpeg4" ? 2 : 0;
    if ((output->oformat->flags & AVFMT_GLOBALHEADER) != 0) {
        encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    }
    REQUIRE(avcodec_open2(encoder, coding, nullptr) == 0);
    AVStream* const stream = avformat_new_stream(output, nullptr);
    REQUIRE(avcodec_parameters_from_context(stream->codecpar, encoder) >= 0);
    stream->time_base = encoder->time_base;
    REQUIRE(avio_open(&output->pb, path.c_str(), AVIO_FLAG_WRITE) >= 0);
    REQUIRE(avformat_write_header(output, nullptr) >= 0);
    AVFrame* frame = av_frame_alloc();
    AVPacket* packet = av_packet_alloc();
    frame->width = width;
    frame->height = height;
    frame->format = encoder->pix_fmt;
    REQUIRE(av_frame_get_buffer(frame, 0) == 0);
    for (int k = 0; k < frames; ++k) {
        REQUIRE(av_frame_make_writable(frame) == 0);
        fill(*frame, k, grey);
        frame->pts = k;
        frame->quality = encoder->global_quality;
        REQUIRE(avcodec_send_frame(encoder, frame) == 0);
        write_ready(output, encoder, packet);
    }
    REQUIRE(avcodec_send_frame(encoder, nullptr) == 0);
    write_ready(output, encoder, packet);
    REQUIRE(av_write_trailer(output) == 0);
    av_packet_free(&packet);
    av_frame_free(&frame);
    avcodec_free_context(&encoder);
    avio_closep(&output->pb);
    avformat_free_context(output);
}

}  // namespace facet::test
