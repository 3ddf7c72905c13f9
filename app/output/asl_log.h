// SPDX-License-Identifier: BSD-2-Clause
// Writes samples into a EuRoC/ASL folder that is a readable log at every moment.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "app/output/sample_log.h"
#include "app/support/append_file.h"

namespace facet {

/// The folder mav0 with cam0, cam1 and imu0 as AslDataset reads it; pairs.csv (what PairOrigin holds) and
/// trigger0/data.csv (edges) beside them, and range0/data.csv
/// if there is a range finder. Images are files at once; rows are held back until commit(), which puts the
/// images on the disk before the rows that name them, and inertial rows before both. So a program that is killed, or a
/// power failure, costs what came since the last commit and nothing else; a full disk, the same. All functions throw
/// InputError naming the path. Thread-bound. Heap.
class AslLog final : public SampleLog {
public:
    /// @param folder  gets the folder mav0, which must not be there yet: no log is ever overwritten
    AslLog(const std::string& folder, bool has_right);
    ~AslLog() override;
    AslLog(const AslLog&) = delete;
    AslLog& operator=(const AslLog&) = delete;

    void add_pair(const PairOrigin& origin, const ImageView& left, const ImageView& right) override;
    void add_imu(const ImuSample& sample) override;
    void add_edge(const TriggerEdge& edge) override;
    void add_range(const RangeSample& sample, Timestamp frame) override;
    void add_file(const std::string& name, const std::string& content) override;
    void commit() override;
    void close() override { commit(); }

private:
    void add_image(int camera, Timestamp stamp, const ImageView& image);
    template <std::size_t N>
    static void add_row(AppendFile& rows, Timestamp stamp, const std::array<std::string, N>& fields);

    std::string root_;
    std::array<std::unique_ptr<AppendFile>, 2> cameras_;  ///< the right one may be missing
    std::unique_ptr<AppendFile> imu_;
    std::unique_ptr<AppendFile> pairs_;
    std::unique_ptr<AppendFile> edges_;
    std::unique_ptr<AppendFile> ranges_;  ///< from the first one on
    int folder_ = -1;                     ///< descriptor of the root
};

}  // namespace facet
