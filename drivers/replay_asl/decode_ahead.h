// SPDX-License-Identifier: BSD-2-Clause
// Decodes the next images of a log while the present ones are in use.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/replay_asl/grey_image.h"
#include "platform/base/status.h"

namespace facet {

class ImageDecoder;

/// Decodes the image files of frames on a thread of its own, in the order in which they are asked for: results are
/// those of ImageDecoder called in turn. An image of a camera whose size is not given must have the size of the
/// camera's first good one. Usage:
///   while (has_room()) ask(...);  const Frame& frame = take();
/// All methods: thread-bound to the caller. Heap: image buffers, which are reused.
class DecodeAhead {
public:
    /// Frames in memory, the one in use among them. A keyframe takes the estimator as long as two or three frames take
    /// to decode: the decoder goes on meanwhile.
    static constexpr std::uint64_t kFrames = 4;

    struct Image {
        std::string path;   ///< empty: the frame has no image of this camera
        Status status{};    ///< of ImageDecoder::decode()
        std::string error;  ///< likewise, unless kOk
        GreyImage grey;
    };
    using Frame = std::array<Image, 2>;

    /// Starts the thread. @param sizes  that the images of either camera must have
    /// @throw std::system_error if there is no thread to be had
    explicit DecodeAhead(const std::array<WantedSize, 2>& sizes);
    /// Waits for the image that is being decoded.
    ~DecodeAhead();
    DecodeAhead(const DecodeAhead&) = delete;
    DecodeAhead& operator=(const DecodeAhead&) = delete;

    /// Whether one more frame may be asked for.
    bool has_room() const { return asked_ - released_ < kFrames; }
    /// Asks for a frame's images; needs room. An empty path: the frame has no image of this camera.
    void ask(const std::array<std::string, 2>& paths);
    /// Waits for the next frame asked for, of which there must be one; it is valid until the next call.
    /// @throw whatever the decoder threw, such as std::bad_alloc
    Frame& take();

private:
    void work();
    void decode(Frame& frame, ImageDecoder& decoder);
    Frame& slot(std::uint64_t number) { return frames_[number % kFrames]; }

    std::array<WantedSize, 2> sizes_;  // the thread's
    std::array<Frame, kFrames> frames_;
    std::uint64_t released_ = 0;  // the caller's: frames no longer in use
    std::uint64_t taken_ = 0;     // the caller's

    std::mutex mutex_;  // of what follows; asked_ is written by the caller only
    std::condition_variable changed_;
    std::uint64_t asked_ = 0;
    std::uint64_t decoded_ = 0;
    bool ends_ = false;
    std::exception_ptr failure_;

    std::thread thread_;  // last: it uses the rest
};

}  // namespace facet
