// SPDX-License-Identifier: BSD-2-Clause
// Writes samples into an MCAP file that is a readable log at every moment.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "app/mcap/log_messages.h"
#include "app/mcap/mcap_writer.h"
#include "app/output/sample_log.h"
#include "app/support/append_file.h"

namespace facet {

/// FOLDER/flight.mcap: the messages of log_messages.h, by which facet convert makes the folder that an AslLog of the
/// same samples would be. Images are PNG files in them. All is held back until commit(), which ends a chunk, and is
/// all there after close(); without that the file lacks its summary, which readers do without. Memory: what comes
/// between two commits, and the index of McapWriter: at two commits and four chunks a second less than 4 MB an hour.
class McapSampleLog final : public SampleLog {
public:
    static constexpr const char* kFileName = "flight.mcap";

    /// @param folder  gets the file, which must not be there yet: no log is ever overwritten
    /// Throws InputError.
    McapSampleLog(const std::string& folder, bool has_right);

    void add_pair(const PairOrigin& origin, const ImageView& left, const ImageView& right) override;
    void add_imu(const ImuSample& sample) override;
    void add_edge(const TriggerEdge& edge) override;
    void add_range(const RangeSample& sample, Timestamp frame) override;
    void add_file(const std::string& name, const std::string& content) override;
    void commit() override;
    void close() override;

    /// For messages of other channels.
    McapWriter& writer() { return *writer_; }
    /// The newest stamp of a sample.
    Timestamp newest() const { return newest_; }

private:
    /// Passes on to the file in pieces of one commit.
    class Sink final : public McapSink {
    public:
        explicit Sink(const std::string& path) : file_(path) {}
        void write(const std::string& bytes) override { pending_ += bytes; }
        void commit();
        void close() override { commit(); }

    private:
        AppendFile file_;
        std::string pending_;
    };

    void add_channel(LogTable table);
    void add_image(LogTable table, Timestamp stamp, const ImageView& image);
    template <std::size_t N>
    void add_row(LogTable table, Timestamp stamp, const std::array<std::string, N>& fields);

    std::string path_;
    std::unique_ptr<Sink> sink_;
    std::unique_ptr<McapWriter> writer_;
    std::array<std::uint16_t, kAllLogTables.size()> channels_{};  ///< by table; zero: there is none
    std::string message_;
    std::vector<std::uint8_t> image_;
    Timestamp newest_;
};

}  // namespace facet
