// SPDX-License-Identifier: BSD-2-Clause
// Writes samples into a EuRoC/ASL folder that is a readable log at every moment.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "platform/base/samples.h"
#include "platform/port/camera_source.h"
#include "platform/port/trigger_source.h"

namespace facet {

/// A file of rows, which reach it in whole lines: what a write leaves of a line that did not fit is cut off again. The
/// constructor, which makes a new file, and commit() throw InputError naming the path. Thread-bound. Heap.
class RowFile {
public:
    RowFile(std::string path, const std::string& header);
    ~RowFile();
    RowFile(const RowFile&) = delete;
    RowFile& operator=(const RowFile&) = delete;

    /// Keeps a line, which ends with \n, until commit().
    void add(const std::string& line) { rows_ += line; }
    /// Brings the lines to the disc.
    void commit();

private:
    [[noreturn]] void fail(int error) const;

    std::string path_;
    std::string rows_;
    off_t size_ = 0;  ///< of the whole lines in the file
    int descriptor_ = -1;
};

/// What the synchroniser knew of a pair of images, beside the images.
struct PairOrigin {
    Timestamp stamp;                          ///< that the estimator was given, without the cameras' time shift
    std::array<Timestamp, 2> camera_stamp;    ///< of left and right image; zero where there is no image
    std::array<std::uint32_t, 2> sequence{};  ///< the cameras' own counts
    std::array<Duration, 2> exposure;         ///< zero if unknown
};

/// The folder mav0 with cam0, cam1 and imu0 as AslDataset reads it; pairs.csv (what PairOrigin holds) and
/// trigger0/data.csv (edges) beside them. Images are files at once; rows are held back until commit(), which puts the
/// images on the disc before the rows that name them. So a program that is killed, or a power failure, costs what came
/// since the last commit and nothing else; a full disc, the same. All functions throw InputError naming the path.
/// Thread-bound. Heap.
class AslLog {
public:
    /// @param folder  gets the folder mav0, which must not be there yet: no log is ever overwritten
    AslLog(const std::string& folder, bool has_right);
    ~AslLog();
    AslLog(const AslLog&) = delete;
    AslLog& operator=(const AslLog&) = delete;

    /// @param left, right  an empty view is left out
    void add_pair(const PairOrigin& origin, const ImageView& left, const ImageView& right);
    void add_imu(const ImuSample& sample);
    void add_edge(const TriggerEdge& edge);
    void commit();

private:
    void add_image(int camera, Timestamp stamp, const ImageView& image);

    std::string root_;
    std::array<std::unique_ptr<RowFile>, 2> cameras_;  ///< the right one may be missing
    std::unique_ptr<RowFile> imu_;
    std::unique_ptr<RowFile> pairs_;
    std::unique_ptr<RowFile> edges_;
    int folder_ = -1;  ///< descriptor of the root
};

}  // namespace facet
