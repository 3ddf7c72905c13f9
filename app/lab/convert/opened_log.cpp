// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/opened_log.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include "app/lab/convert/bag.h"
#include "app/lab/convert/import_files.h"
#include "app/lab/convert/mcap_log.h"
#include "app/lab/convert/unpack_log.h"
#include "app/support/input_error.h"
#include "drivers/replay_asl/asl_dataset.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

class OwningStream : public std::istream {
public:
    explicit OwningStream(std::unique_ptr<std::streambuf> buffer)
        : std::istream(buffer.get()), buffer_(std::move(buffer)) {}

private:
    std::unique_ptr<std::streambuf> buffer_;
};

/// Paths begin with the MCAP file's own, as if it were a folder.
class McapLogFiles : public LogFiles {
public:
    McapLogFiles(const std::string& path, const McapFile::Warn& warn) : log_(path, warn), begin_(path + "/") {}

    McapLog& log() { return log_; }

    bool has_folder(const std::string& path) override {
        return path + "/" == begin_ || (is_inside(path) && log_.has_folder(inner(path)));
    }
    std::unique_ptr<std::istream> open(const std::string& path) override {
        std::unique_ptr<std::streambuf> buffer = is_inside(path) ? log_.open(inner(path)) : nullptr;
        return buffer == nullptr ? nullptr : std::make_unique<OwningStream>(std::move(buffer));
    }
    std::string read(const std::string& path, std::size_t most_bytes, std::vector<std::uint8_t>& bytes) override {
        switch (is_inside(path) ? log_.read(inner(path), most_bytes, bytes) : Status::kNotFound) {
            case Status::kOk: return "";
            case Status::kNotFound: return std::strerror(ENOENT);
            case Status::kFull: return "is too large";
            default: return "is damaged in the MCAP file";
        }
    }

private:
    bool is_inside(const std::string& path) const { return path.starts_with(begin_); }
    std::string inner(const std::string& path) const { return path.substr(begin_.size()); }

    McapLog log_;
    std::string begin_;
};

/// The logs below a folder of several, such as EuRoC's.
std::string first_log_below(const std::string& path) {
    std::error_code ignored;
    std::string first;
    for (const fs::directory_entry& entry : fs::directory_iterator(path, ignored)) {
        const std::string root = AslDataset::find_root(entry.path().string());
        if (!root.empty() && fs::exists(root + "/cam0", ignored) && (first.empty() || entry.path().string() < first)) {
            first = entry.path().string();
        }
    }
    return first;
}

/// "X_log" beside X.
std::string log_beside(const std::string& path) {
    const fs::path whole = fs::path(path).has_filename() ? fs::path(path) : fs::path(path).parent_path();
    return whole.stem().string() + "_log";
}

[[noreturn]] void refuse_images(const std::string& path) {
    const std::string log = log_beside(path);
    throw InputError(path +
                     ": holds images, of which facet convert makes a log together with a table of inertial "
                     "samples: facet convert " +
                     path + " " + log +
                     " --imu imu.csv (--right FILE for the other "
                     "camera) && facet replay " +
                     log + " --out result");
}

/// What is no log says what it is instead, and what to type.
[[noreturn]] void refuse(const std::string& path) {
    if (is_bag(path)) {
        const std::string log = log_beside(path);
        throw InputError(path + ": is a bag, of which facet convert makes a log: facet convert " + path + " " + log +
                         " && facet replay " + log + " --out result");
    }
    std::error_code ignored;
    if (!fs::is_directory(path, ignored)) {
        if (fs::exists(path, ignored) && is_image_source(path)) {
            refuse_images(path);
        }
        throw InputError(path + ": is not a log: neither a folder, nor an MCAP file of one, nor a bag of ROS");
    }
    if (const std::string below = first_log_below(path); !below.empty()) {
        throw InputError(path + ": is not a log but contains some: " + below + " is one");
    }
    if (is_image_source(path)) {
        refuse_images(path);
    }
    if (const std::string inner = image_source_in(path); !inner.empty()) {
        refuse_images(inner);
    }
    throw InputError(
        path + ": is not a log: it has neither cam0/data.csv nor mav0/cam0/data.csv (docs/use.md, Your own data)");
}

}  // namespace

OpenedLog::OpenedLog(const std::string& path, const McapFile::Warn& warn) : folder_(path) {
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) {
        root_ = AslDataset::find_root(path);
        if (root_.empty()) {
            throw InputError(path + ": no such folder");
        }
        if (!fs::exists(root_ + "/cam0", ignored)) {
            refuse(path);
        }
        return;
    }
    if (!McapFile::recognises(path)) {
        refuse(path);
    }
    try {
        extract(path, warn);
    } catch (...) {
        fs::remove_all(temporary_, ignored);
        throw;
    }
}

OpenedLog::~OpenedLog() {
    if (!temporary_.empty()) {
        std::error_code ignored;
        fs::remove_all(temporary_, ignored);
    }
}

void OpenedLog::extract(const std::string& path, const McapFile::Warn& warn) {
    constexpr std::size_t kMostBytes = std::size_t{64} << 20U;
    auto files = std::make_unique<McapLogFiles>(path, warn);
    McapLog& log = files->log();
    if (!log.is_log()) {
        refuse(path);
    }
    std::string folder = (fs::temp_directory_path() / "facet_log_XXXXXX").string();
    if (mkdtemp(folder.data()) == nullptr) {
        throw InputError(folder + ": cannot be made: " + std::strerror(errno));
    }
    temporary_ = folder_ = folder;
    std::vector<std::uint8_t> bytes;
    for (const std::string& name : log.names()) {
        const bool is_table_of_sensor = log.is_table(name) && name.find("groundtruth") == std::string::npos;
        if (!is_table_of_sensor && !name.ends_with(".png") && ok(log.read(name, kMostBytes, bytes))) {
            const fs::path target = fs::path(folder) / name;
            fs::create_directories(target.parent_path());
            write_whole_file(target.string(), bytes);
        }
    }
    root_ = AslDataset::find_root(folder);
    files_ = std::move(files);
}

ImageExtent extent_of_images(const std::string& path, LogFiles* files) {
    AslDataset log;
    AslOptions options;
    options.files = files;
    options.left_only = true;
    std::string ignored;
    if (!ok(log.open(path, options, nullptr, ignored))) {
        return {};
    }
    ImuSample imu;
    StereoFrame frame;
    for (;;) {
        switch (log.next(imu, frame)) {
            case AslDataset::Event::kFrame: return {frame.left.width, frame.left.height};
            case AslDataset::Event::kEnd: return {};
            default: break;
        }
    }
}

}  // namespace facet
