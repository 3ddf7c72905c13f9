// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/asl_dataset.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kImuColumns = 7;

std::string column_text(std::size_t index) { return "column " + std::to_string(index + 1); }

}  // namespace

const char* to_string(AslWarningKind kind) {
    switch (kind) {
        case AslWarningKind::kMalformedRow: return "malformed_row";
        case AslWarningKind::kNotFinite: return "not_finite";
        case AslWarningKind::kDuplicate: return "duplicate_stamp";
        case AslWarningKind::kOutOfOrder: return "out_of_order";
        case AslWarningKind::kMissingRight: return "missing_right";
        case AslWarningKind::kMissingLeft: return "missing_left";
        case AslWarningKind::kApart: return "pairs_apart";
        case AslWarningKind::kMissingFile: return "missing_file";
        case AslWarningKind::kCorruptImage: return "corrupt_image";
        case AslWarningKind::kWrongSize: return "wrong_size";
        case AslWarningKind::kImuGap: return "imu_gap";
        case AslWarningKind::kUncovered: return "uncovered_frame";
        case AslWarningKind::kCount: break;
    }
    return "unknown";
}

std::string AslWarning::text() const { return file + ":" + std::to_string(line) + ": " + message; }

void AslDataset::warn(AslWarningKind kind, const std::string& file, std::int64_t line, std::string message) const {
    if (sink_) {
        sink_({.kind = kind, .file = file, .line = line, .message = std::move(message)});
    }
}

std::string AslDataset::find_root(const std::string& path) {
    std::error_code ignored;
    if (!fs::is_directory(path, ignored)) {
        return {};
    }
    const fs::path inner = fs::path(path) / "mav0";
    return (fs::is_directory(inner, ignored) ? inner : fs::path(path)).string();
}

Status AslDataset::open(const std::string& path, const AslOptions& options, AslWarningSink sink, std::string& error) {
    *this = AslDataset();
    options_ = options;
    sink_ = std::move(sink);
    if (!has_folder(path)) {
        error = path + ": no such folder";
        return Status::kIo;
    }
    const std::string root = has_folder(path + "/mav0") ? (fs::path(path) / "mav0").string() : path;
    camera_csv_ = {(fs::path(root) / "cam0" / "data.csv").string(), (fs::path(root) / "cam1" / "data.csv").string()};

    std::vector<ImageRow> left;
    std::vector<ImageRow> right;
    FACET_TRY(load_images(camera_csv_[0], left, error));
    has_right_ = !options_.left_only && has_folder((fs::path(root) / "cam1").string());
    if (has_right_) {
        FACET_TRY(load_images(camera_csv_[1], right, error));
    }
    if (left.size() > 1) {
        const auto count = static_cast<std::int64_t>(left.size());
        period_.ns = (left.back().stamp - left.front().stamp).ns / (count - 1) * count;
    }
    const std::string imu_path = (fs::path(root) / "imu0" / "data.csv").string();
    if (!open_table(imu_path, imu_csv_)) {
        error = imu_path + ": cannot be read";
        return Status::kIo;
    }
    ImuRow first;
    if (!next_imu(first)) {
        error = imu_path + ": holds no valid row";
        return Status::kIo;
    }
    imu_ahead_ = first;
    log_begin_ = left.front().stamp;
    pair_images(left, right);
    return Status::kOk;
}

Status AslDataset::load_images(const std::string& csv_path, std::vector<ImageRow>& rows, std::string& error) {
    CsvFile csv;
    if (!open_table(csv_path, csv)) {
        error = csv_path + ": cannot be read";
        return Status::kIo;
    }
    IncreasingRows<ImageRow> filter;
    const auto read = [&](ImageRow& row) { return read_image_row(csv, row); };
    const auto skip = [&](AslWarningKind kind, std::int64_t line, const char* message) {
        warn(kind, csv_path, line, message);
    };
    ImageRow row;
    while (filter.next(read, skip, row)) {
        rows.push_back(row);
    }
    if (csv.failed() || rows.empty()) {
        error = csv_path + (csv.failed() ? ": read error" : ": holds no valid row");
        return Status::kIo;
    }
    return Status::kOk;
}

bool AslDataset::read_image_row(CsvFile& csv, ImageRow& row) {
    while (csv.next(fields_)) {
        row.line = csv.line();
        if (fields_.size() != 2 || fields_[1].empty()) {
            warn(AslWarningKind::kMalformedRow, csv.path(), row.line, "row is not 'stamp,file name'; row skipped");
            continue;
        }
        if (!parse_stamp(fields_[0], row.stamp.ns)) {
            warn(AslWarningKind::kMalformedRow, csv.path(), row.line, "stamp is not an integer (ns); row skipped");
            continue;
        }
        row.stamp = row.stamp + options_.camera_time_shift;
        row.file = fields_[1];
        return true;
    }
    return false;
}

bool AslDataset::read_imu_row(ImuRow& row) {
    while (imu_csv_.next(fields_)) {
        row.line = imu_csv_.line();
        const auto skip = [&](AslWarningKind kind, const std::string& what) {
            warn(kind, imu_csv_.path(), row.line, what + "; row skipped");
        };
        if (fields_.size() != kImuColumns) {
            skip(AslWarningKind::kMalformedRow, "row has " + std::to_string(fields_.size()) + " columns, not 7");
            continue;
        }
        if (!parse_stamp(fields_[0], row.stamp.ns)) {
            skip(AslWarningKind::kMalformedRow, "stamp is not an integer (ns)");
            continue;
        }
        std::array<double, kImuColumns> x{};
        std::size_t i = 1;
        while (i < kImuColumns && parse_double(fields_[i], x[i]) && std::isfinite(x[i])) {
            ++i;
        }
        if (i < kImuColumns) {
            double number = 0.0;
            const bool is_number = parse_double(fields_[i], number);
            skip(is_number ? AslWarningKind::kNotFinite : AslWarningKind::kMalformedRow,
                 column_text(i) + (is_number ? " is not finite" : " is not a number"));
            continue;
        }
        row.sample = {.stamp = row.stamp, .w_B = {x[1], x[2], x[3]}, .a_B = {x[4], x[5], x[6]}};
        return true;
    }
    return false;
}

bool AslDataset::next_imu(ImuRow& row) {
    const auto read = [this](ImuRow& r) { return read_imu_row(r); };
    const auto skip = [this](AslWarningKind kind, std::int64_t line, const char* message) {
        warn(kind, imu_csv_.path(), line, message);
    };
    for (;;) {
        const bool is_last_turn = imu_turn_ + 1 >= options_.loops;
        const bool found = imu_filter_.next(read, skip, row);
        if (found && (is_last_turn || !imu_begin_.has_value() || row.stamp - *imu_begin_ < period_)) {
            break;
        }
        if (is_last_turn || !next_imu_turn()) {
            return false;
        }
    }
    imu_begin_ = imu_begin_.value_or(row.stamp);
    row.stamp = row.stamp + Duration{imu_turn_ * period_.ns};
    row.sample.stamp = row.stamp;
    if (imu_before_.has_value() && row.stamp - *imu_before_ > options_.imu_gap) {
        warn(AslWarningKind::kImuGap, imu_csv_.path(), row.line,
             "no inertial data for " + std::to_string((row.stamp - *imu_before_).seconds()) + " s before this row");
    }
    imu_before_ = row.stamp;
    return true;
}

/// The inertial rows from the beginning again.
bool AslDataset::next_imu_turn() {
    ++imu_turn_;
    imu_filter_ = {};
    const std::string path = imu_csv_.path();
    return open_table(path, imu_csv_);
}

bool AslDataset::has_folder(const std::string& path) const {
    std::error_code ignored;
    return options_.files != nullptr ? options_.files->has_folder(path) : fs::is_directory(path, ignored);
}

bool AslDataset::open_table(const std::string& path, CsvFile& csv) const {
    return options_.files != nullptr ? csv.open(path, options_.files->open(path)) : csv.open(path);
}

void AslDataset::pair_images(std::vector<ImageRow>& left, std::vector<ImageRow>& right) {
    const Timestamp begin = log_begin_ + options_.start;
    const auto in_window = [&](Timestamp t) {
        return t >= begin && (!options_.length.has_value() || t - begin <= *options_.length);
    };
    const auto stamps_of = [](const std::vector<ImageRow>& rows) {
        std::vector<Timestamp> stamps;
        stamps.reserve(rows.size());
        for (const ImageRow& row : rows) {
            stamps.push_back(row.stamp);
        }
        return stamps;
    };
    std::vector<Duration> skews;
    std::int64_t first_apart = 0;  // line
    for (const StampPair& p : pair_stamps(stamps_of(left), stamps_of(right), options_.pair_tolerance)) {
        ImageRow* const l = p.left != StampPair::kNone ? &left[p.left] : nullptr;
        ImageRow* const r = p.right != StampPair::kNone ? &right[p.right] : nullptr;
        const Timestamp stamp = l != nullptr ? l->stamp : r->stamp;
        if (!in_window(stamp)) {
            continue;
        }
        Pair pair{stamp, std::nullopt, std::nullopt};
        if (l != nullptr) {
            pair.left = std::move(*l);
        }
        switch (p.kind) {
            case StampPair::Kind::kTogether: pair.right = std::move(*r); break;
            case StampPair::Kind::kApart:
                first_apart = skews.empty() ? r->line : first_apart;
                skews.push_back(r->stamp - stamp);
                break;
            case StampPair::Kind::kLeftOnly:
                if (has_right_) {
                    warn(AslWarningKind::kMissingRight, camera_csv_[0], pair.left->line,
                         "no right image for this left one; frame has a left view only");
                }
                break;
            case StampPair::Kind::kRightOnly:
                warn(AslWarningKind::kMissingLeft, camera_csv_[1], r->line,
                     "no left image for this right one; frame has a right view only");
                pair.right = std::move(*r);
                ++right_only_;
                break;
            case StampPair::Kind::kSurplus:
                warn(AslWarningKind::kMissingLeft, camera_csv_[1], r->line,
                     "a second right image for the same left one; skipped");
                continue;
        }
        pairs_.push_back(std::move(pair));
    }
    warn_of_skew(summarize_skews(skews), first_apart);
}

void AslDataset::warn_of_skew(const StampSkew& skew, std::int64_t line) const {
    if (skew.count == 0) {
        return;
    }
    std::array<char, 320> text{};
    std::snprintf(
        text.data(), text.size(),
        "the cameras do not expose together: in %zu of %zu frames (%.1f %%) the right image's stamp is %+.3f ms "
        "from the left one's (median; %+.3f to %+.3f), and a pair's differ by %g ms at most; these frames have a "
        "left view only",
        skew.count, pairs_.size(), 100.0 * static_cast<double>(skew.count) / static_cast<double>(pairs_.size()),
        1e3 * skew.median.seconds(), 1e3 * skew.least.seconds(), 1e3 * skew.most.seconds(),
        1e3 * options_.pair_tolerance.seconds());
    warn(AslWarningKind::kApart, camera_csv_[1], line, text.data());
}

Timestamp AslDataset::pair_stamp(std::size_t number) const {
    return pair(number).stamp + Duration{static_cast<std::int64_t>(number / pairs_.size()) * period_.ns};
}

bool AslDataset::give_frame(Duration delay, StereoFrame& frame) {
    while (next_pair_ < frame_count() && imu_given_.has_value() && pair_stamp(next_pair_) + delay <= *imu_given_) {
        if (load_frame(next_pair_++, frame)) {
            return true;
        }
    }
    return false;
}

bool AslDataset::give_imu(ImuSample& sample) {
    while (imu_ahead_.has_value()) {
        const ImuRow row = *imu_ahead_;
        ImuRow next;
        imu_ahead_ = next_imu(next) ? std::optional<ImuRow>(next) : std::nullopt;
        // Before the first sample is delivered: drop frames that precede it, and data long before the first frame.
        while (!imu_given_.has_value() && next_pair_ < frame_count() && pair_stamp(next_pair_) < row.stamp) {
            warn(AslWarningKind::kUncovered, camera_csv_[0], pair(next_pair_++).line(),
                 "frame is before the first inertial sample; frame skipped");
        }
        if (is_out_of_frames() && (pairs_.empty() || row.stamp > pair_stamp(frame_count() - 1) + options_.imu_tail)) {
            return false;
        }
        if (!imu_given_.has_value() && !is_out_of_frames() && row.stamp < pair_stamp(next_pair_) - options_.imu_lead) {
            continue;
        }
        imu_given_ = row.stamp;
        sample = row.sample;
        return true;
    }
    return false;
}

AslDataset::Event AslDataset::next(ImuSample& imu, StereoFrame& frame) {
    if (give_frame(options_.frame_delay, frame)) {
        return Event::kFrame;
    }
    if ((!is_out_of_frames() || options_.imu_tail.ns > 0) && give_imu(imu)) {
        return Event::kImu;
    }
    if (give_frame({}, frame)) {
        return Event::kFrame;
    }
    for (; next_pair_ < frame_count(); ++next_pair_) {
        warn(AslWarningKind::kUncovered, camera_csv_[0], pair(next_pair_).line(),
             "frame is after the last inertial sample; frame skipped");
    }
    return Event::kEnd;
}

}  // namespace facet
