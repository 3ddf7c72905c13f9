// SPDX-License-Identifier: BSD-2-Clause
// Reader of a recorded stereo-inertial log in the EuRoC/ASL folder format.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/replay_asl/csv_file.h"
#include "drivers/replay_asl/decode_ahead.h"
#include "drivers/replay_asl/image_decoder.h"
#include "drivers/replay_asl/increasing_rows.h"
#include "drivers/replay_asl/log_files.h"
#include "drivers/replay_asl/stamp_pairs.h"
#include "drivers/replay_asl/warning.h"
#include "platform/base/samples.h"
#include "platform/base/status.h"

namespace facet {

/// Required size of an image (px); zero for any.
struct ImageSize {
    int width = 0;
    int height = 0;
};

/// How a dataset is read.
struct AslOptions {
    Duration pair_tolerance = Duration::from_seconds(1e-3);  ///< largest difference of the stamps of one stereo pair
    Duration imu_gap = Duration::from_seconds(0.05);         ///< a longer step between inertial samples is a gap
    Duration imu_lead = Duration::from_seconds(2.0);         ///< inertial data delivered before the first frame
    Duration imu_tail;               ///< of the inertial data after the last frame that are delivered, too
    Duration frame_delay;            ///< a frame comes when inertial data are this far past its stamp, or have ended
    Duration camera_time_shift;      ///< added to image stamps: t_imu = t_cam + shift
    Duration start;                  ///< skips frames up to this long after the first one
    std::optional<Duration> length;  ///< of the window of frames after start; all if empty
    ImageSize left_size;
    ImageSize right_size;
    /// How often the log is given, each time with its stamps a period later: all frames and one frame interval. The log
    /// must end as it began; inertial rows later than a period after the first serve the last turn only. Not to be
    /// combined with start and length.
    int loops = 1;
    LogFiles* files = nullptr;  ///< where the files are, if not on the disk; borrowed
    bool left_only = false;     ///< the log has one camera, whatever it has
    bool decode_images = true;  ///< else frames come with empty views, and no image file is opened
    /// Images on the disk are decoded on a second thread, ahead of time: same samples, same warnings between them.
    bool decode_ahead = false;
};

/// A log folder with cam0, cam1 and imu0, each with data.csv (stamps in integer ns); cam1 may be missing. Usage:
///   AslDataset log;
///   if (!ok(log.open("MH_01_easy", {}, print_warning, error))) { ... }
///   for (;;) switch (log.next(imu, frame)) { case kImu: ...; case kFrame: ...; case kEnd: return; }
/// Bad data never stops the run: each bad row or image is reported to the sink with file and line, and skipped.
/// Image lists are read at open, inertial rows and images on demand. Thread-bound.
class AslDataset {
public:
    enum class Event : std::uint8_t { kImu, kFrame, kEnd };

    /// The folder with cam0, cam1 and imu0: `path`/mav0 if there is one, else `path`. Empty if `path` is not a folder.
    static std::string find_root(const std::string& path);

    /// Opens a folder that contains mav0/ or is mav0/ itself.
    /// @return kIo with `error` naming the path if it does not exist, or a data.csv cannot be read or has no valid row
    Status open(const std::string& path, const AslOptions& options, AslWarningSink sink, std::string& error);

    /// Next sample in order of time. A frame comes right after the first inertial sample at or after its stamp plus
    /// frame_delay, which is when an estimator can use it, or at the end of the inertial data; frames after the last
    /// inertial sample are skipped with a warning, and inertial ones up to imu_tail behind the last frame come as well.
    /// A frame's views stay valid until the next call; one of them is empty if its image is missing or bad.
    Event next(ImuSample& imu, StereoFrame& frame);

    /// Number of frames that will be delivered if none is bad.
    std::size_t frame_count() const { return pairs_.size() * static_cast<std::size_t>(options_.loops); }
    /// Whether the last frame has been delivered, or skipped.
    bool is_out_of_frames() const { return next_pair_ >= frame_count(); }
    /// Frames among them without a left row: of the right camera's rows alone.
    std::size_t right_only_count() const { return right_only_ * static_cast<std::size_t>(options_.loops); }
    /// Stamp of the first frame of the log, including the camera shift, whatever part of the log the options select.
    Timestamp log_begin() const { return log_begin_; }

private:
    struct ImageRow {
        Timestamp stamp;
        std::int64_t line = 0;
        std::string file;
    };
    struct ImuRow {
        Timestamp stamp;
        std::int64_t line = 0;
        ImuSample sample;
    };
    struct Pair {
        Timestamp stamp;
        std::optional<ImageRow> left;
        std::optional<ImageRow> right;
        std::int64_t line() const { return left.has_value() ? left->line : right->line; }
    };

    void warn(AslWarningKind kind, const std::string& file, std::int64_t line, std::string message) const;
    Status load_images(const std::string& csv_path, std::vector<ImageRow>& rows, std::string& error);
    bool read_image_row(CsvFile& csv, ImageRow& row);
    bool read_imu_row(ImuRow& row);
    bool next_imu(ImuRow& row);
    void pair_images(std::vector<ImageRow>& left, std::vector<ImageRow>& right);
    /// @param line  of the first right image that is apart
    void warn_of_skew(const StampSkew& skew, std::int64_t line) const;
    const Pair& pair(std::size_t number) const { return pairs_[number % pairs_.size()]; }
    Timestamp pair_stamp(std::size_t number) const;
    bool load_frame(std::size_t number, StereoFrame& frame);
    bool next_imu_turn();
    bool has_folder(const std::string& path) const;
    bool open_table(const std::string& path, CsvFile& csv) const;
    Status decode(const std::string& path, const ImageSize& size, GreyImage& image);
    std::string image_path(const std::optional<ImageRow>& row, int camera) const;
    bool load_image(const std::optional<ImageRow>& row, int camera, GreyImage& image);
    /// Complains unless the image is good. @return whether it is
    bool judge_image(Status status, const std::string& error, const ImageRow& row, int camera) const;
    bool load_frame_ahead(std::size_t number, StereoFrame& frame);
    void ask_ahead();
    bool give_frame(Duration delay, StereoFrame& frame);
    bool give_imu(ImuSample& sample);

    AslOptions options_;
    AslWarningSink sink_;
    std::array<std::string, 2> camera_csv_;
    bool has_right_ = true;  ///< there is a folder cam1
    Timestamp log_begin_;

    std::vector<Pair> pairs_;
    std::size_t right_only_ = 0;
    std::size_t next_pair_ = 0;  ///< of all turns
    Duration period_;            ///< of one turn

    CsvFile imu_csv_;
    std::vector<std::string_view> fields_;
    IncreasingRows<ImuRow> imu_filter_;
    int imu_turn_ = 0;
    std::optional<Timestamp> imu_begin_;  // stamp of the first row
    std::optional<ImuRow> imu_ahead_;
    std::optional<Timestamp> imu_before_;  // stamp of the last row read, to find gaps
    std::optional<Timestamp> imu_given_;   // stamp of the last sample delivered

    ImageDecoder decoder_;
    std::vector<std::uint8_t> file_;  ///< of an image that is not on the disk
    std::string unread_;              ///< why such an image could not be read
    std::array<GreyImage, 2> images_;
    std::unique_ptr<DecodeAhead> ahead_;  ///< from the first frame given on
    std::size_t next_asked_ = 0;          ///< pair that it is to be asked for
};

}  // namespace facet
