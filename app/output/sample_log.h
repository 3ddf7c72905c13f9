// SPDX-License-Identifier: BSD-2-Clause
// A log of samples as they come, whatever its form.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "platform/base/image_view.h"
#include "platform/base/range_sample.h"
#include "platform/base/samples.h"
#include "platform/port/camera_source.h"
#include "platform/port/trigger_source.h"

namespace facet {

/// What the synchroniser knew of a pair of images, beside the images.
struct PairOrigin {
    Timestamp stamp;                          ///< that the estimator was given, without the cameras' time shift
    std::array<Timestamp, 2> camera_stamp;    ///< of left and right image; zero where there is no image
    std::array<std::uint32_t, 2> sequence{};  ///< the cameras' own counts
    std::array<Duration, 2> exposure;         ///< zero if unknown
};

/// A log that is readable at every moment: a program that is killed, or a power failure, costs what came since the last
/// commit and nothing else; a full disk, the same. All functions throw InputError naming the path. Thread-bound. Heap.
class SampleLog {
public:
    virtual ~SampleLog() = default;
    /// @param left, right  an empty view is left out
    virtual void add_pair(const PairOrigin& origin, const ImageView& left, const ImageView& right) = 0;
    virtual void add_imu(const ImuSample& sample) = 0;
    virtual void add_edge(const TriggerEdge& edge) = 0;
    /// @param frame  stamp of the frame before which the estimator was given it
    virtual void add_range(const RangeSample& sample, Timestamp frame) = 0;
    /// A small file beside the tables, such as a calibration; at the start, so that a log cut off has it.
    /// @param name  below the log's root
    virtual void add_file(const std::string& name, const std::string& content) = 0;
    /// Brings everything to the disk.
    virtual void commit() = 0;
    /// Likewise, and completes the log: nothing may follow.
    virtual void close() = 0;
};

/// The fields of a table's row behind the stamp; doubles as the shortest text that reads back the same. Reentrant.
std::array<std::string, 6> fields_of(const ImuSample& sample);
std::array<std::string, 6> fields_of(const PairOrigin& origin);
std::array<std::string, 2> fields_of(const TriggerEdge& edge);
std::array<std::string, 4> fields_of(const RangeSample& sample, Timestamp frame);

}  // namespace facet
