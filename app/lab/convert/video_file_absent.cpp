// SPDX-License-Identifier: BSD-2-Clause
// Without libavformat and libavcodec.
#include "app/lab/convert/video_file.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "app/support/input_error.h"

namespace facet {

struct VideoFile::Streams {
    std::vector<std::int64_t> stamps_ns;
};

bool VideoFile::is_built_in() { return false; }

bool VideoFile::recognises(const std::string& path) {
    constexpr std::array<std::string_view, 10> kEndings{".mp4", ".avi",  ".mkv", ".mov",  ".webm",
                                                        ".m4v", ".h264", ".ts",  ".mpeg", ".mpg"};
    return std::ranges::any_of(kEndings, [&](std::string_view ending) { return path.ends_with(ending); });
}

VideoFile::VideoFile(const std::string& path) {
    throw InputError(
        path +
        ": video files need a build with libavformat and libavcodec (scripts/setup --video, then build "
        "again); without them ffmpeg makes a folder of images of it: ffmpeg -i FILE -vsync 0 FOLDER/%06d.png");
}
VideoFile::~VideoFile() = default;

const std::vector<std::int64_t>& VideoFile::stamps_ns() const { return streams_->stamps_ns; }
bool VideoFile::has_stamps() const { return false; }
bool VideoFile::next(std::size_t& /*number*/, GreyImage& /*grey*/) { return false; }

}  // namespace facet
