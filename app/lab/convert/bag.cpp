// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/bag.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <utility>

#include "app/lab/convert/ros1_bag.h"
#include "app/lab/convert/sqlite_bag.h"
#include "app/lab/mcap/mcap_file.h"
#include "app/mcap/compressed_file.h"
#include "app/mcap/compression.h"
#include "app/support/input_error.h"
#include "app/support/yaml_file.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

class McapBag : public Bag {
public:
    McapBag(const std::string& path, const Warn& warn, const std::atomic<bool>* stop) : file_(path, warn, stop) {
        for (const auto& [id, channel] : file_.channels()) {
            if (channel.encoding == "cdr" || channel.encoding == "ros1") {
                const WireFormat wire = channel.encoding == "cdr" ? WireFormat::kCdr : WireFormat::kRos1;
                topics_[id] = {channel.topic, short_type(channel.schema), wire};
            }
        }
    }

    bool next(BagMessage& message) override {
        for (McapMessage found; file_.next(cursor_, found);) {
            if (const auto topic = topics_.find(found.channel); topic != topics_.end()) {
                message = {&topic->second, found.time_ns, found.data};
                return true;
            }
        }
        return false;
    }
    double share() const override { return file_.share(cursor_); }

private:
    McapFile file_;
    McapFile::Cursor cursor_;
    std::map<std::uint16_t, BagTopic> topics_;
};

/// A bag whose messages may be compressed, each of its own.
class PlainBag : public Bag {
public:
    PlainBag(std::unique_ptr<Bag> bag, Warn warn) : bag_(std::move(bag)), warn_(std::move(warn)) {}

    bool next(BagMessage& message) override {
        constexpr std::size_t kMostBytes = std::size_t{256} << 20U;
        if (!bag_->next(message)) {
            return false;
        }
        // CDR begins with a zero, so that neither magic can be a message's own.
        if (message.topic->wire == WireFormat::kCdr && compression_of(message.data) != Compression::kNone) {
            if (!ok(decompress_frame(message.data, kMostBytes, bytes_)) && !is_warned_) {
                is_warned_ = true;
                warn_("a message of " + message.topic->name + " is compressed and damaged");
            }
            message.data = bytes_;
        }
        return true;
    }
    double share() const override { return bag_->share(); }

private:
    std::unique_ptr<Bag> bag_;
    Warn warn_;
    std::vector<std::uint8_t> bytes_;
    bool is_warned_ = false;
};

/// A bag in a file that is compressed as a whole: read from a copy, which goes with the object.
class DecompressedBag : public Bag {
public:
    DecompressedBag(const std::string& path, const Warn& warn, const std::atomic<bool>* stop) {
        std::string folder = (fs::temp_directory_path() / "facet_bag_XXXXXX").string();
        if (mkdtemp(folder.data()) == nullptr) {
            throw InputError(folder + ": cannot be made: " + std::strerror(errno));
        }
        folder_ = folder;
        try {
            const std::string copy = folder + "/" + fs::path(path).stem().string();
            std::error_code unknown;
            const std::uintmax_t bytes = fs::file_size(path, unknown);
            const std::uint64_t most_bytes = most_unpacked(unknown ? 0 : bytes);
            if (const std::string problem = decompress_file(path, copy, most_bytes, stop); !problem.empty()) {
                throw InputError(problem);
            }
            if (stop != nullptr && stop->load()) {
                return;  // nothing is read
            }
            if (is_zstd_file(copy)) {
                throw InputError(path + ": is compressed twice");
            }
            bag_ = open_bag(copy, warn, stop);
        } catch (...) {
            remove();
            throw;
        }
    }
    ~DecompressedBag() override { remove(); }

    bool next(BagMessage& message) override { return bag_ != nullptr && bag_->next(message); }
    double share() const override { return bag_ != nullptr ? bag_->share() : 0.0; }

private:
    void remove() {
        std::error_code ignored;
        bag_.reset();
        fs::remove_all(folder_, ignored);
    }

    std::string folder_;
    std::unique_ptr<Bag> bag_;
};

/// Several files, one behind the other. Only one is open at a time.
class BagFolder : public Bag {
public:
    BagFolder(std::vector<std::string> files, Warn warn, const std::atomic<bool>* stop)
        : files_(std::move(files)), warn_(std::move(warn)), stop_(stop) {}

    bool next(BagMessage& message) override {
        for (; number_ < files_.size(); ++number_, open_.reset()) {
            if (open_ == nullptr) {
                open_ = open_bag(files_[number_], warn_, stop_);
            }
            if (open_->next(message)) {
                return true;
            }
            if (stop_ != nullptr && stop_->load()) {
                return false;
            }
        }
        return false;
    }
    double share() const override {
        const double inner = open_ == nullptr ? 0.0 : open_->share();
        return (static_cast<double>(number_) + inner) / static_cast<double>(files_.size());
    }

private:
    std::vector<std::string> files_;
    Warn warn_;
    const std::atomic<bool>* stop_;
    std::size_t number_ = 0;
    std::unique_ptr<Bag> open_;
};

/// Whether a single file is a bag; compressed ones are told by their names as well.
bool is_bag_file(const std::string& path) {
    return McapFile::recognises(path) || Ros1Bag::recognises(path) || SqliteBag::recognises(path) || is_zstd_file(path);
}

/// Of a folder whose recorder has left no metadata.yaml: its bags by name.
std::vector<std::string> bags_in(const std::string& folder) {
    std::vector<std::string> files;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        if (entry.is_regular_file(error) && is_bag_file(entry.path().string())) {
            files.push_back(entry.path().string());
        }
    }
    std::ranges::sort(files);
    return files;
}

std::vector<std::string> files_of_folder(const std::string& folder) {
    if (!fs::exists(folder + "/metadata.yaml")) {
        std::vector<std::string> files = bags_in(folder);
        if (files.empty()) {
            throw InputError(folder + ": has neither metadata.yaml nor a bag in it");
        }
        return files;
    }
    const YamlNode names =
        load_yaml(folder + "/metadata.yaml").at("rosbag2_bagfile_information").at("relative_file_paths");
    std::vector<std::string> files;
    for (const auto& name : names.raw()) {
        if (!name.IsScalar()) {
            names.fail("must be a list of file names");
        }
        files.push_back((fs::path(folder) / name.Scalar()).string());
    }
    if (files.empty()) {
        names.fail("names no file");
    }
    return files;
}

std::unique_ptr<Bag> open_bag_file(const std::string& path, const Bag::Warn& warn, const std::atomic<bool>* stop) {
    if (McapFile::recognises(path)) {
        return std::make_unique<McapBag>(path, warn, stop);
    }
    if (Ros1Bag::recognises(path)) {
        return std::make_unique<Ros1Bag>(path, warn, stop);
    }
    if (SqliteBag::recognises(path)) {
        return std::make_unique<SqliteBag>(path, warn);
    }
    throw InputError(path + ": is neither a ROS 1 bag of format 2.0 nor an MCAP file nor a bag of ROS 2 in sqlite3");
}

}  // namespace

std::string short_type(std::string type) {
    if (const std::size_t at = type.find("/msg/"); at != std::string::npos) {
        type.erase(at, 4);
    }
    return type;
}

bool is_bag(const std::string& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) {
        return fs::exists(path + "/metadata.yaml", ignored) || !bags_in(path).empty();
    }
    return is_bag_file(path);
}

std::unique_ptr<Bag> open_bag(const std::string& path, const Bag::Warn& warn, const std::atomic<bool>* stop) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) {
        return std::make_unique<BagFolder>(files_of_folder(path), warn, stop);
    }
    if (is_zstd_file(path)) {
        return std::make_unique<DecompressedBag>(path, warn, stop);
    }
    return std::make_unique<PlainBag>(open_bag_file(path, warn, stop), warn);
}

}  // namespace facet
