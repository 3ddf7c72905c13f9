// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/convert_arguments.h"
#include "app/commands/run_guarded.h"
#include "app/lab/convert/import_files.h"
#include "app/mcap/log_messages.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

std::string topic_of(const ConvertArguments& args, LogTable table) {
    return args.topics[static_cast<std::size_t>(table)];
}

FilesOptions files_options(const ConvertArguments& args) {
    if (!topic_of(args, LogTable::kLeft).empty()) {
        throw InputError("--left: names a topic of a bag; the left camera's images are the first argument");
    }
    if (!topic_of(args, LogTable::kTruth).empty()) {
        throw InputError("--groundtruth: names a topic of a bag; facet eval --groundtruth FILE compares with a table");
    }
    FilesOptions options;
    options.images = {args.input, topic_of(args, LogTable::kRight)};
    const std::size_t comma = args.stamps.find(',');
    options.stamps = {args.stamps.substr(0, comma), comma == std::string::npos ? "" : args.stamps.substr(comma + 1)};
    options.imu = topic_of(args, LogTable::kImu);
    options.folder = args.output;
    options.cameras = args.cameras;
    options.imu_calibration = args.imu;
    options.is_side_by_side = args.is_side_by_side;
    options.align_clocks = args.align_clocks;
    return options;
}

void print_files(const ConvertArguments& args, const FilesAccount& account) {
    constexpr std::array kSides{"left", "right"};
    for (std::size_t side = 0; side < 2; ++side) {
        if (account.images[side] + account.left_out[side] > 0) {
            print_out("{:<12} {}: {} images, {} left out\n", kSides[side],
                      side == 0              ? args.input
                      : args.is_side_by_side ? "the other half"
                                             : topic_of(args, LogTable::kRight),
                      account.images[side], account.left_out[side]);
        }
    }
    print_out("{:<12} {}: {} samples, {} rows left out\n", "imu", topic_of(args, LogTable::kImu), account.samples,
              account.samples_left_out);
    if (account.has_calibration) {
        print_out("calibration  as given\n");
    } else {
        print_out(
            "calibration  none. Convert with --calibration and --imu-calibration, or replay with them:\n"
            "             facet replay {} --out result --calibration FILE --imu-calibration imu.yaml\n",
            args.output);
    }
    print_out("folder       {}\n", args.output);
}

}  // namespace

int convert_files(const ConvertArguments& args, const std::atomic<bool>& stop) {
    Narrator narrator(args.quiet);
    FilesOptions options = files_options(args);
    options.progress = [&](double share) { narrator.update(static_cast<std::size_t>(share * kPermille)); };
    options.warn = [&](const std::string& line) { narrator.warn(line); };
    const FilesAccount account = import_files(options, stop);
    narrator.finish();
    if (stop.load()) {
        print_error("interrupted");
        return kExitFailed;
    }
    for (const std::string& remark : account.remarks) {
        print_err("warning: {}\n", remark);
    }
    print_files(args, account);
    if (account.images[0] == 0) {
        print_error("the log has no images");
        return kExitFailed;
    }
    return kExitDone;
}

}  // namespace facet
