// SPDX-License-Identifier: BSD-2-Clause
// A kernel with devices of industrial I/O, whose scans a test writes.
#pragma once

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"

namespace facet::test {

/// Files of sysfs by their paths, and nodes that give what was pushed. Waiting moves the clock.
class FakeIio final : public FakeKernel {
public:
    static constexpr const char* kSysfs = "/sys/bus/iio/devices/";

    explicit FakeIio(ManualClock& clock) : clock_(clock) {}

    /// The attribute of a device's folder.
    std::string& file(const std::string& folder, const std::string& name) {
        return files[kSysfs + folder + "/" + name];
    }
    bool has(const std::string& folder, const std::string& name) const {
        return files.count(kSysfs + folder + "/" + name) != 0;
    }
    void remove(const std::string& folder, const std::string& name) { files.erase(kSysfs + folder + "/" + name); }

    /// Adds a device with a buffer and stamps. @param index  of the element of stamps, the last one
    void add_device(const std::string& folder, const std::string& name, int stamp_index) {
        file(folder, "name") = name;
        file(folder, "current_timestamp_clock") = "realtime";
        file(folder, "buffer/enable") = "0";
        file(folder, "buffer/length") = "2";
        file(folder, "buffer/watermark") = "1";
        add_element(folder, "in_timestamp", stamp_index, "le:s64/64>>0");
        nodes["/dev/" + folder];
    }
    void add_element(const std::string& folder, const std::string& element, int index, const std::string& type) {
        file(folder, "scan_elements/" + element + "_en") = "0";
        file(folder, "scan_elements/" + element + "_index") = std::to_string(index);
        file(folder, "scan_elements/" + element + "_type") = type;
    }
    /// x, y and z of in_anglvel or in_accel.
    void add_axes(const std::string& folder, const std::string& type, int index, const std::string& format,
                  const std::string& scale) {
        for (const char* axis : {"_x", "_y", "_z"}) {
            add_element(folder, type + axis, index++, format);
        }
        file(folder, type + "_scale") = scale;
    }
    /// What one read gives; dropped unless the buffer is on.
    void push(const std::string& folder, std::vector<std::uint8_t> bytes) {
        if (file(folder, "buffer/enable") == "1") {
            nodes["/dev/" + folder].push_back(std::move(bytes));
        }
    }
    /// Unplugs: its files are gone, its node fails.
    void unplug(const std::string& folder) {
        gone_.insert(folder);
        nodes["/dev/" + folder].clear();
    }
    void plug(const std::string& folder) {
        gone_.erase(folder);
        file(folder, "buffer/enable") = "0";
    }

    std::map<std::string, std::string> files;
    std::map<std::string, std::deque<std::vector<std::uint8_t>>> nodes;
    std::map<std::string, int> refusals;  ///< -errno of opening or of writing, by the end of the path
    std::function<void(const std::string& path, std::string& value)> on_write;
    std::vector<std::string> written;  ///< "path=value" below kSysfs, in order
    int open_nodes = 0;

    int open(const char* path, int flags) override {
        const std::string name(path);
        const bool is_folder = (flags & O_DIRECTORY) != 0;
        const auto below = files.lower_bound(name + "/");
        const bool is_there = is_folder ? below != files.end() && below->first.rfind(name + "/", 0) == 0
                                        : files.count(name) != 0 || nodes.count(name) != 0;
        if (!is_there || is_gone(name)) {
            return -ENOENT;
        }
        if (const int error = refusal(name, flags); error != 0) {
            return error;
        }
        open_nodes += nodes.count(name) != 0 ? 1 : 0;
        open_[next_] = {name, is_folder ? children_of(name) : std::vector<std::string>{}};
        return next_++;
    }
    int close(int fd) override {
        open_nodes -= nodes.count(open_.at(fd).path) != 0 ? 1 : 0;
        open_.erase(fd);
        return 0;
    }
    std::int64_t read(int fd, void* buffer, std::size_t size) override {
        const std::string& path = open_.at(fd).path;
        const auto node = nodes.find(path);
        if (node == nodes.end()) {
            std::string text = files.at(path) + "\n";
            if (path.ends_with("/current_timestamp_clock")) {
                text.push_back('\0');  // as the kernel does
            }
            std::memcpy(buffer, text.data(), std::min(size, text.size()));
            return static_cast<std::int64_t>(std::min(size, text.size()));
        }
        if (is_gone(path)) {
            return -ENODEV;
        }
        if (node->second.empty()) {
            return -EAGAIN;
        }
        const std::vector<std::uint8_t> bytes = node->second.front();
        node->second.pop_front();
        std::memcpy(buffer, bytes.data(), std::min(size, bytes.size()));
        return static_cast<std::int64_t>(std::min(size, bytes.size()));
    }
    std::int64_t write(int fd, const void* buffer, std::size_t size) override {
        const std::string& path = open_.at(fd).path;
        std::string value(static_cast<const char*>(buffer), size);
        if (on_write) {
            on_write(path.substr(std::strlen(kSysfs)), value);
        }
        files.at(path) = value;
        written.push_back(path.substr(std::strlen(kSysfs)) + "=" + value);
        return static_cast<std::int64_t>(size);
    }
    std::int64_t read_folder(int fd, void* buffer, std::size_t size) override {
        std::vector<std::string>& left = open_.at(fd).left;
        std::size_t used = 0;
        while (!left.empty()) {
            const std::size_t record = (19 + left.back().size() + 1 + 7) / 8 * 8;
            if (used + record > size) {
                break;
            }
            auto* const at = static_cast<char*>(buffer) + used;
            std::memset(at, 0, record);
            const auto length = static_cast<std::uint16_t>(record);
            std::memcpy(at + 16, &length, sizeof length);
            std::memcpy(at + 19, left.back().data(), left.back().size());
            left.pop_back();
            used += record;
        }
        return static_cast<std::int64_t>(used);
    }
    int wait_readable(int fd, Duration timeout) override {
        const std::string& path = open_.at(fd).path;
        if (!nodes.at(path).empty() || is_gone(path)) {
            return 1;
        }
        clock_.advance(timeout);
        return 0;
    }

private:
    struct Open {
        std::string path;
        std::vector<std::string> left;  ///< names of a folder
    };

    bool is_gone(const std::string& path) const {
        return std::any_of(gone_.begin(), gone_.end(),
                           [&](const std::string& folder) { return path.find("/" + folder) != std::string::npos; });
    }
    int refusal(const std::string& path, int flags) const {
        for (const auto& [end, error] : refusals) {
            const bool fits = path.size() >= end.size() && path.compare(path.size() - end.size(), end.size(), end) == 0;
            if (fits && ((flags & O_ACCMODE) == O_WRONLY || nodes.count(path) != 0)) {
                return error;
            }
        }
        return 0;
    }
    std::vector<std::string> children_of(const std::string& folder) const {
        std::set<std::string> names{".", ".."};
        for (const auto& [path, value] : files) {
            if (path.rfind(folder + "/", 0) == 0 && !is_gone(path)) {
                const std::string rest = path.substr(folder.size() + 1);
                names.insert(rest.substr(0, rest.find('/')));
            }
        }
        return {names.begin(), names.end()};
    }

    ManualClock& clock_;
    std::map<int, Open> open_;
    std::set<std::string> gone_;
    int next_ = 5;
};

/// A scan as bytes: what is added is aligned to its size.
class ScanBytes {
public:
    ScanBytes& add(std::int64_t value, std::size_t size, bool is_big_endian = false) {
        bytes_.resize((bytes_.size() + size - 1) / size * size);
        for (std::size_t i = 0; i < size; ++i) {
            const std::size_t byte = is_big_endian ? size - 1 - i : i;
            bytes_.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * byte)));
        }
        return *this;
    }
    ScanBytes& add(std::initializer_list<int> values, std::size_t size, bool is_big_endian = false) {
        for (const int value : values) {
            add(value, size, is_big_endian);
        }
        return *this;
    }
    operator std::vector<std::uint8_t>() const { return bytes_; }

private:
    std::vector<std::uint8_t> bytes_;
};

}  // namespace facet::test
