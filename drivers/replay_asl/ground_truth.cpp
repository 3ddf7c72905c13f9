// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/ground_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "drivers/replay_asl/csv_file.h"

namespace facet {
namespace {

constexpr std::size_t kPoseColumns = 8;
constexpr std::size_t kFullColumns = 17;
constexpr double kNormTolerance = 0.01;

using Warn = std::function<void(AslWarningKind, std::string)>;

bool parse_row(const std::vector<std::string_view>& fields, const Warn& warn, GroundTruthState& state) {
    if (fields.size() != kPoseColumns && fields.size() != kFullColumns) {
        warn(AslWarningKind::kMalformedRow,
             "ground truth row has " + std::to_string(fields.size()) + " columns, not 8 or 17; row skipped");
        return false;
    }
    if (!parse_stamp(fields[0], state.stamp.ns)) {
        warn(AslWarningKind::kMalformedRow, "stamp is not an integer (ns); row skipped");
        return false;
    }
    std::array<double, kFullColumns> x{};
    for (std::size_t i = 1; i < fields.size(); ++i) {
        if (!parse_double(fields[i], x[i])) {
            warn(AslWarningKind::kMalformedRow, "column " + std::to_string(i + 1) + " is not a number; row skipped");
            return false;
        }
        if (!std::isfinite(x[i])) {
            warn(AslWarningKind::kNotFinite, "column " + std::to_string(i + 1) + " is not finite; row skipped");
            return false;
        }
    }
    state.p_W_B = {x[1], x[2], x[3]};
    state.q_W_B = Eigen::Quaterniond(x[4], x[5], x[6], x[7]);
    if (std::abs(state.q_W_B.norm() - 1.0) > kNormTolerance) {
        warn(AslWarningKind::kMalformedRow, "quaternion is not of unit length; row skipped");
        return false;
    }
    state.q_W_B.normalize();
    state.has_motion = fields.size() == kFullColumns;
    state.v_W_B = {x[8], x[9], x[10]};
    state.gyro_bias = {x[11], x[12], x[13]};
    state.accel_bias = {x[14], x[15], x[16]};
    return true;
}

}  // namespace

std::string find_ground_truth(const std::string& path) {
    namespace fs = std::filesystem;
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored)) {
        return path;
    }
    const fs::path table = fs::path("state_groundtruth_estimate0") / "data.csv";
    for (const fs::path& candidate : {fs::path(path) / "mav0" / table, fs::path(path) / table}) {
        if (fs::is_regular_file(candidate, ignored)) {
            return candidate.string();
        }
    }
    return {};
}

Status read_ground_truth(const std::string& csv_path, const AslWarningSink& sink, std::vector<GroundTruthState>& states,
                         std::string& error) {
    CsvFile csv;
    if (!csv.open(csv_path)) {
        error = csv_path + ": cannot be read";
        return Status::kIo;
    }
    const Warn warn = [&](AslWarningKind kind, std::string message) {
        if (sink) {
            sink({.kind = kind, .file = csv.path(), .line = csv.line(), .message = std::move(message)});
        }
    };
    std::vector<GroundTruthState> rows;
    std::vector<std::string_view> fields;
    while (csv.next(fields)) {
        GroundTruthState state;
        if (!parse_row(fields, warn, state)) {
            continue;
        }
        if (!rows.empty() && state.stamp <= rows.back().stamp) {
            const bool equal = state.stamp == rows.back().stamp;
            warn(equal ? AslWarningKind::kDuplicate : AslWarningKind::kOutOfOrder,
                 equal ? "stamp is that of the row before; row skipped" : "stamp goes back in time; row skipped");
            continue;
        }
        rows.push_back(state);
    }
    if (csv.failed() || rows.empty()) {
        error = csv_path + (csv.failed() ? ": read error" : ": holds no valid row");
        return Status::kIo;
    }
    states = std::move(rows);
    return Status::kOk;
}

std::optional<GroundTruthState> interpolate(std::span<const GroundTruthState> truth, Timestamp t, Duration max_gap) {
    const auto after = std::lower_bound(truth.begin(), truth.end(), t,
                                        [](const GroundTruthState& s, Timestamp stamp) { return s.stamp < stamp; });
    if (after == truth.end()) {
        return std::nullopt;
    }
    if (after->stamp == t) {
        return *after;
    }
    if (after == truth.begin() || after->stamp - std::prev(after)->stamp > max_gap) {
        return std::nullopt;
    }
    const GroundTruthState& a = *std::prev(after);
    const double s = static_cast<double>((t - a.stamp).ns) / static_cast<double>((after->stamp - a.stamp).ns);
    GroundTruthState out;
    out.stamp = t;
    out.p_W_B = (1.0 - s) * a.p_W_B + s * after->p_W_B;
    out.q_W_B = a.q_W_B.slerp(s, after->q_W_B);
    out.has_motion = a.has_motion && after->has_motion;
    out.v_W_B = (1.0 - s) * a.v_W_B + s * after->v_W_B;
    out.gyro_bias = (1.0 - s) * a.gyro_bias + s * after->gyro_bias;
    out.accel_bias = (1.0 - s) * a.accel_bias + s * after->accel_bias;
    return out;
}

}  // namespace facet
