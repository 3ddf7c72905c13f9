// SPDX-License-Identifier: BSD-2-Clause
#include "tests/app/lab/convert/test_video.h"

namespace facet::test {

bool can_write_videos() { return false; }

void write_video(const std::string& /*path*/, const char* /*codec*/, const char* /*format*/, int /*width*/,
                 int /*height*/, int /*frames*/, const std::function<int(int k, int u, int v)>& /*grey*/) {}

}  // namespace facet::test
