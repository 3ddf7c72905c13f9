// SPDX-License-Identifier: BSD-2-Clause
// Frames of a video file as 8-bit grey.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/replay_asl/grey_image.h"

namespace facet {

/// The first video track of any container and coding that libavformat and libavcodec read. Luma as it is stored, in
/// the full range of its numbers; colours become luma(); more than 8 bits are cut. Notes of a rotation in the file are
/// not applied: a calibration is of the sensor. Thread-bound. Heap.
class VideoFile {
public:
    /// Whether this build has these libraries; else the constructor throws.
    static bool is_built_in();

    /// Whether a file has a video track, by its beginning; without the libraries, whether it is called like one.
    static bool recognises(const std::string& path);

    /// Opens it and reads the frames' stamps, without decoding. Throws InputError if it is no video file.
    explicit VideoFile(const std::string& path);
    ~VideoFile();
    VideoFile(const VideoFile&) = delete;
    VideoFile& operator=(const VideoFile&) = delete;

    /// Of all frames in the order in which they are shown, by the container's clock, which mostly begins at zero. Their
    /// number counts if has_stamps() is false, as for a bare stream of H.264.
    const std::vector<std::int64_t>& stamps_ns() const;
    bool has_stamps() const;

    /// Decodes the next frame that can be. @param number  of the frame, from 0: those between are damaged
    /// @return false at the end
    bool next(std::size_t& number, GreyImage& grey);

private:
    struct Streams;
    std::unique_ptr<Streams> streams_;
};

}  // namespace facet
