// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/convert_command.h"

#include <CLI/CLI.hpp>
#include <array>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "app/commands/convert_arguments.h"
#include "app/commands/run_guarded.h"
#include "app/commands/stop_signal.h"
#include "app/lab/convert/bag.h"
#include "app/lab/convert/image_list.h"
#include "app/lab/convert/import_bag.h"
#include "app/lab/convert/import_files.h"
#include "app/lab/convert/mcap_log.h"
#include "app/lab/convert/pack_log.h"
#include "app/lab/convert/unpack_log.h"
#include "app/lab/convert/video_file.h"
#include "app/support/input_error.h"
#include "drivers/replay_asl/asl_dataset.h"

namespace facet {
namespace {

int interrupted() {
    print_error("interrupted");
    return kExitFailed;
}

int pack(const ConvertArguments& args, const std::atomic<bool>& stop) {
    Narrator narrator(args.quiet);
    PackOptions options;
    options.folder = args.input;
    options.file = args.output;
    options.library = "facet";
    options.compression = *find_compression(args.compression);
    options.progress = [&](double share) { narrator.update(static_cast<std::size_t>(share * kPermille)); };
    options.warn = [&](const std::string& line) { narrator.warn(line); };
    const PackAccount account = pack_log(options, stop);
    narrator.finish();
    if (stop.load()) {
        return interrupted();
    }
    const auto count = [&](LogTable table) { return account.messages[static_cast<std::size_t>(table)]; };
    print_out("messages     {} left, {} right, {} inertial, {} of ground truth\n", count(LogTable::kLeft),
              count(LogTable::kRight), count(LogTable::kImu), count(LogTable::kTruth));
    print_out("attachments  {}\n", account.attachments);
    print_out("file         {}, {:.1f} MB\n", args.output,
              static_cast<double>(std::filesystem::file_size(args.output)) * 1e-6);
    return kExitDone;
}

int unpack(McapLog& log, const ConvertArguments& args, Narrator& narrator, const std::atomic<bool>& stop) {
    const UnpackAccount account = unpack_log(
        log, args.output, [&](std::uint64_t done) { narrator.update(done * kPermille / log.image_count()); }, stop);
    narrator.finish();
    if (stop.load()) {
        return interrupted();
    }
    print_out("files        {}, {} of them images, in {}\n", account.files, account.images, args.output);
    return kExitDone;
}

/// What the log lacks, and where it is to be had.
void print_calibration(const ConvertArguments& args, const ImportAccount& account) {
    if (account.has_calibration) {
        print_out("calibration  {}\n", account.is_own_calibration
                                           ? "the bag's own: camera_info and /tf_static; the IMU's "
                                             "noise is assumed"
                                           : "as given");
        return;
    }
    print_out(
        "calibration  none: {}. Convert with --calibration and --imu-calibration, or replay\n"
        "             with them, for example with Kalibr's files: facet replay {} --out result\n"
        "             --calibration camchain.yaml --imu-calibration imu.yaml\n",
        account.calibration_lack.empty() ? "the bag has none" : account.calibration_lack, args.output);
}

int import(const ConvertArguments& args, const std::atomic<bool>& stop) {
    constexpr std::array<const char*, 4> kLabels{"left", "right", "imu", "ground truth"};
    Narrator narrator(args.quiet);
    ImportOptions options;
    options.bag = args.input;
    options.folder = args.output;
    options.topics = args.topics;
    options.cameras = args.cameras;
    options.imu = args.imu;
    options.bits = args.bits;
    options.is_side_by_side = args.is_side_by_side;
    options.align_clocks = args.align_clocks;
    options.progress = [&](double share) { narrator.update(static_cast<std::size_t>(share * kPermille)); };
    options.warn = [&](const std::string& line) { narrator.warn(line); };
    const ImportAccount account = import_bag(options, stop);
    narrator.finish();
    if (stop.load()) {
        return interrupted();
    }
    for (const std::string& remark : account.remarks) {
        print_err("warning: {}\n", remark);
    }
    for (const LogTable table : kLogTables) {
        const auto i = static_cast<std::size_t>(table);
        if (table == LogTable::kRight && args.is_side_by_side) {
            print_out("{:<12} the other half\n", kLabels[i]);
        } else if (table == LogTable::kImu && !account.accelerometer.empty()) {
            print_out("{:<12} {} with {} interpolated: {} rows, {} messages left out\n", kLabels[i], account.topics[i],
                      account.accelerometer, account.rows[i], account.left_out[i]);
        } else if (account.topics[i].empty()) {
            print_out("{:<12} none\n", kLabels[i]);
        } else {
            print_out("{:<12} {}: {} rows, {} messages left out\n", kLabels[i], account.topics[i], account.rows[i],
                      account.left_out[i]);
        }
    }
    if (account.bits != 16) {
        print_out("bits         {} of 16\n", account.bits);
    }
    print_calibration(args, account);
    print_out("folder       {}\n", args.output);
    for (const LogTable table : {LogTable::kLeft, LogTable::kImu}) {
        if (account.rows[static_cast<std::size_t>(table)] == 0) {
            print_error("the log has no images, or no inertial samples");
            return kExitFailed;
        }
    }
    return kExitDone;
}

/// An MCAP file of ours is unpacked, others are bags.
int convert_mcap(const ConvertArguments& args, const std::atomic<bool>& stop) {
    {
        Narrator narrator(args.quiet);
        McapLog log(
            args.input, [&](const std::string& line) { narrator.warn(line); }, &stop);
        if (stop.load()) {
            return interrupted();
        }
        if (log.is_log()) {
            return unpack(log, args, narrator, stop);
        }
    }
    return import(args, stop);
}

/// --video stands for the first argument, and a second one for --right.
ConvertArguments with_videos(ConvertArguments args) {
    if (args.videos.empty()) {
        return args;
    }
    if (args.videos.size() > 2 || (!args.input.empty() && !args.output.empty())) {
        throw InputError("--video: one or two files, and the folder for the log alone besides");
    }
    args.output = args.output.empty() ? args.input : args.output;
    args.input = args.videos[0];
    if (args.videos.size() == 2) {
        args.topics[static_cast<std::size_t>(LogTable::kRight)] = args.videos[1];
    }
    return args;
}

int convert(const ConvertArguments& typed) {
    const ConvertArguments args = with_videos(typed);
    if (args.input.empty() || args.output.empty()) {
        throw InputError("what to convert and where to, both are needed: facet convert INPUT OUTPUT");
    }
    const std::optional<Compression> compression = find_compression(args.compression);
    if (!compression.has_value() || *compression == Compression::kBz2) {
        throw InputError("--compression " + args.compression + ": unknown; must be one of: none, lz4, zstd");
    }
    const std::atomic<bool>& stop = stop_on_signals({SIGINT, SIGTERM, SIGHUP});
    if (!std::filesystem::exists(args.input)) {
        throw InputError(args.input + ": does not exist");
    }
    if (McapFile::recognises(args.input)) {
        return convert_mcap(args, stop);
    }
    const bool is_folder = std::filesystem::is_directory(args.input);
    const bool is_log = is_folder && std::filesystem::exists(AslDataset::find_root(args.input) + "/cam0");
    if (!is_log && is_bag(args.input)) {
        return import(args, stop);
    }
    if (!is_log && (is_image_source(args.input) || is_text_file(args.input))) {
        return convert_files(args, stop);
    }
    if (!is_folder) {
        throw InputError(args.input +
                         ": is neither a log folder, nor an MCAP file, nor a ROS bag, nor a list of images, nor a "
                         "video" +
                         (VideoFile::is_built_in() ? "" : " (which this build does not read)"));
    }
    if (!is_log) {
        const std::string inner = image_source_in(args.input);
        throw InputError(args.input + ": is not a log folder: it has neither cam0/data.csv nor mav0/cam0/data.csv" +
                         (inner.empty() ? "" : "; " + inner + " can be converted, with --imu FILE"));
    }
    if (!args.output.ends_with(".mcap")) {
        throw InputError(args.output + ": a folder becomes a file; its name must end in .mcap");
    }
    return pack(args, stop);
}

}  // namespace

void add_convert_command(CLI::App& app, int& exit_code) {
    CLI::App* command = app.add_subcommand(
        "convert", "Convert a log folder to an MCAP file and back, or a ROS bag, images or videos to a log folder");
    auto args = std::make_shared<ConvertArguments>();
    command->add_option(
        "INPUT", args->input,
        "Log folder (EuRoC/ASL), an MCAP file made of one, or a bag of ROS 1 (2.0) or ROS 2 (MCAP, sqlite3; also "
        "compressed): a file, or the folder with its metadata.yaml; or the left camera's images: a list of files "
        "with stamps (TUM's rgb.txt, a CSV), a folder of files named by their stamps, or a video");
    command->add_option("OUTPUT,--out", args->output, "FILE.mcap, or for a file a folder that is new or empty")
        ->type_name("PATH");
    command->add_option("--video", args->videos, "Instead of INPUT; twice: left and right")
        ->type_name("FILE")
        ->expected(1)
        ->allow_extra_args(false)
        ->take_all();
    command
        ->add_option("--stamps", args->stamps,
                     "Table with a stamp for each frame of a video, or image of a folder; LEFT,RIGHT if they differ")
        ->type_name("FILE");
    command->add_option("--compression", args->compression, "Of an MCAP file's chunks: none, lz4 or zstd")
        ->type_name("NAME")
        ->capture_default_str();
    const auto add_topic = [&](const char* option, LogTable table, const char* what) {
        command
            ->add_option(option, args->topics[static_cast<std::size_t>(table)],
                         std::string("Topic of a bag, found by its type by default; or file: ") + what)
            ->type_name("SOURCE");
    };
    add_topic("--left", LogTable::kLeft, "images of the left camera (bags only)");
    add_topic("--right", LogTable::kRight, "images of the right camera");
    add_topic("--imu", LogTable::kImu,
              "inertial samples, or GYROSCOPE,ACCELEROMETER if they have a topic or file each");
    add_topic("--groundtruth", LogTable::kTruth, "true poses of the body (bags only)");
    command
        ->add_option(
            "--calibration", args->cameras,
            "For the log of a bag, or of images: a calibration of any kind that facet replay takes; without it that of "
            "the bag, if it has camera_info and /tf_static")
        ->type_name("FILE");
    command->add_option("--imu-calibration", args->imu, "Kalibr's imu.yaml beside it")->type_name("FILE");
    command->add_flag("--side-by-side", args->is_side_by_side, "Each image of --left holds the left and the right one");
    command
        ->add_option("--bits", args->bits,
                     "Bits used in images of 16 bits: 8, 10, 12, 14 or 16; 0: as many as the brightest pixel needs")
        ->type_name("N")
        ->check(CLI::IsMember({0, 8, 10, 12, 14, 16}))
        ->capture_default_str();
    command->add_flag("--align-clocks", args->align_clocks,
                      "Shift inertial stamps to the images' clock if the two have no time in common");
    command->add_flag("--quiet", args->quiet, "No progress on stderr");
    command->footer(
        "Every file of a folder, calibration and ground truth among them, comes back byte for byte.\n"
        "Exit codes: 0 done; 1 interrupted, or a bag gave no images or no inertial samples; 2 bad usage or input, or "
        "the output cannot be written.");
    command->callback([args, &exit_code] { exit_code = run_guarded([&] { return convert(*args); }); });
}

}  // namespace facet
