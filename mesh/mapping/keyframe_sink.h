// SPDX-License-Identifier: BSD-2-Clause
// Who is given each keyframe that has a mesh.
#pragma once

#include <cstdint>

#include "estimator/values/keyframe_view.h"
#include "platform/base/image_view.h"

namespace facet {

class KeyframeSink {
public:
    virtual ~KeyframeSink() = default;
    /// Called on the mapping's thread: must neither wait nor use the heap. Views and images are valid during the call
    /// only.
    /// @param resets  how often the estimator has restarted
    virtual void take(const KeyframeView& view, std::uint32_t resets, const ImageView& left,
                      const ImageView& right) = 0;
};

}  // namespace facet
