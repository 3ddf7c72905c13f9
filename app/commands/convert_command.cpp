// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/convert_command.h"

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "app/commands/run_guarded.h"
#include "app/commands/stop_signal.h"
#include "app/lab/convert/pack_log.h"
#include "app/lab/convert/unpack_log.h"
#include "app/support/console.h"
#include "app/support/input_error.h"
#include "app/support/progress.h"

namespace facet {
namespace {

/// What the user typed.
struct ConvertArguments {
    std::string input;
    std::string output;
    std::string compression = "zstd";
    bool quiet = false;
};

/// Warnings on stderr, without breaking the progress; beyond kMost they are only counted.
class Narrator {
public:
    Narrator(bool quiet, std::string label, std::string unit, std::size_t total)
        : progress_(std::move(label), std::move(unit), total), quiet_(quiet) {}

    void update(std::size_t done) {
        if (!quiet_) {
            progress_.update(done);
        }
    }
    void warn(const std::string& line) {
        if (++warnings_ <= kMost) {
            progress_.note("warning: " + line);
        }
    }
    void finish() {
        if (!quiet_) {
            progress_.finish();
        }
        if (warnings_ > kMost) {
            print_err("warning: and {} more\n", warnings_ - kMost);
        }
    }
    std::size_t warnings() const { return warnings_; }

private:
    static constexpr std::size_t kMost = 20;
    Progress progress_;
    bool quiet_;
    std::size_t warnings_ = 0;
};

int interrupted() {
    print_error("interrupted");
    return kExitFailed;
}

int pack(const ConvertArguments& args, const std::atomic<bool>& stop) {
    constexpr std::size_t kPermille = 1000;
    Narrator narrator(args.quiet, "convert", "permille", kPermille);
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

int unpack(const ConvertArguments& args, const std::atomic<bool>& stop) {
    std::unique_ptr<Narrator> narrator;
    McapLog log(args.input, [&](const std::string& line) {
        if (narrator) {
            narrator->warn(line);
        } else {
            print_err("warning: {}\n", line);
        }
    });
    if (!log.is_log()) {
        throw InputError(args.input + ": was not made by facet convert");
    }
    narrator = std::make_unique<Narrator>(args.quiet, "convert", "images", log.image_count());
    const UnpackAccount account = unpack_log(
        log, args.output, [&](std::uint64_t done) { narrator->update(done); }, stop);
    narrator->finish();
    if (stop.load()) {
        return interrupted();
    }
    print_out("files        {}, {} of them images, in {}\n", account.files, account.images, args.output);
    return kExitDone;
}

int convert(const ConvertArguments& args) {
    const std::optional<Compression> compression = find_compression(args.compression);
    if (!compression.has_value() || *compression == Compression::kBz2) {
        throw InputError("--compression " + args.compression + ": unknown; must be one of: none, lz4, zstd");
    }
    const std::atomic<bool>& stop = stop_on_signals({SIGINT, SIGTERM, SIGHUP});
    if (std::filesystem::is_directory(args.input)) {
        if (!args.output.ends_with(".mcap")) {
            throw InputError(args.output + ": a folder becomes a file; its name must end in .mcap");
        }
        return pack(args, stop);
    }
    if (!std::filesystem::exists(args.input)) {
        throw InputError(args.input + ": does not exist");
    }
    if (McapFile::recognises(args.input)) {
        return unpack(args, stop);
    }
    throw InputError(args.input + ": is neither a log folder nor an MCAP file");
}

}  // namespace

void add_convert_command(CLI::App& app, int& exit_code) {
    CLI::App* command = app.add_subcommand("convert", "Make an MCAP file of a log folder, or the folder of the file");
    auto args = std::make_shared<ConvertArguments>();
    command->add_option("INPUT", args->input, "Log folder (EuRoC/ASL), or an MCAP file made of one")->required();
    command->add_option("OUTPUT", args->output, "FILE.mcap, or for a file a folder that is new or empty")->required();
    command->add_option("--compression", args->compression, "Of an MCAP file's chunks: none, lz4 or zstd")
        ->capture_default_str();
    command->add_flag("--quiet", args->quiet, "No progress on stderr");
    command->footer(
        "Every file of the folder, calibration and ground truth among them, comes back byte for byte.\n"
        "Exit codes: 0 done; 1 interrupted; 2 bad usage or input, or the output cannot be written.");
    command->callback([args, &exit_code] { exit_code = run_guarded([&] { return convert(*args); }); });
}

}  // namespace facet
