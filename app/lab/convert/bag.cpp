// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/bag.h"

#include <filesystem>
#include <map>
#include <utility>

#include "app/lab/convert/ros1_bag.h"
#include "app/lab/convert/sqlite_bag.h"
#include "app/lab/mcap/mcap_file.h"
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

std::vector<std::string> files_of_folder(const std::string& folder) {
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

}  // namespace

std::string short_type(std::string type) {
    if (const std::size_t at = type.find("/msg/"); at != std::string::npos) {
        type.erase(at, 4);
    }
    return type;
}

std::unique_ptr<Bag> open_bag(const std::string& path, const Bag::Warn& warn, const std::atomic<bool>* stop) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) {
        return std::make_unique<BagFolder>(files_of_folder(path), warn, stop);
    }
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

}  // namespace facet
