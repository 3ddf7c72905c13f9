// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/asl_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <filesystem>
#include <utility>

#include "app/mcap/log_messages.h"
#include "app/support/append_file.h"
#include "app/support/input_error.h"
#include "app/support/png_writer.h"
#include "app/support/text_file.h"

namespace facet {
namespace {

/// A new table of a log, with its header.
std::unique_ptr<AppendFile> begin_table(const std::string& root, LogTable table) {
    auto rows = std::make_unique<AppendFile>(root + "/" + names_of(table).file);
    rows->add(names_of(table).header);
    return rows;
}

}  // namespace

AslLog::AslLog(const std::string& folder, bool has_right) : root_(folder + "/mav0") {
    if (std::filesystem::exists(root_)) {
        throw InputError(root_ + ": there is a log already");
    }
    make_folder(root_ + "/cam0/data");
    make_folder(root_ + "/imu0");
    make_folder(root_ + "/trigger0");
    cameras_[0] = begin_table(root_, LogTable::kLeft);
    if (has_right) {
        make_folder(root_ + "/cam1/data");
        cameras_[1] = begin_table(root_, LogTable::kRight);
    }
    imu_ = begin_table(root_, LogTable::kImu);
    pairs_ = begin_table(root_, LogTable::kPairs);
    edges_ = begin_table(root_, LogTable::kEdges);
    folder_ = ::open(root_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    commit();
}

AslLog::~AslLog() {
    if (folder_ >= 0) {
        ::close(folder_);
    }
}

void AslLog::add_image(int camera, Timestamp stamp, const ImageView& image) {
    AppendFile* const rows = cameras_[static_cast<std::size_t>(camera)].get();
    if (image.empty() || rows == nullptr) {
        return;
    }
    const std::string path = fmt::format("{}/cam{}/data/{}.png", root_, camera, stamp.ns);
    if (!ok(write_png(path, image))) {
        (void)::unlink(path.c_str());  // half an image is none
        throw InputError(path + ": cannot be written");
    }
    rows->add(fmt::format("{0},{0}.png\n", stamp.ns));
}

void AslLog::add_pair(const PairOrigin& origin, const ImageView& left, const ImageView& right) {
    add_image(0, origin.stamp, left);
    add_image(1, origin.stamp, right);
    add_row(*pairs_, origin.stamp, fields_of(origin));
}

/// The fields behind the stamp.
template <std::size_t N>
void AslLog::add_row(AppendFile& rows, Timestamp stamp, const std::array<std::string, N>& fields) {
    rows.add(fmt::format("{},{}\n", stamp.ns, fmt::join(fields, ",")));
}

void AslLog::add_imu(const ImuSample& sample) { add_row(*imu_, sample.stamp, fields_of(sample)); }

void AslLog::add_edge(const TriggerEdge& edge) { add_row(*edges_, edge.stamp, fields_of(edge)); }

void AslLog::add_range(const RangeSample& sample, Timestamp frame) {
    if (ranges_ == nullptr) {
        make_folder(root_ + "/range0");
        ranges_ = begin_table(root_, LogTable::kRanges);
    }
    add_row(*ranges_, sample.stamp, fields_of(sample, frame));
}

void AslLog::add_file(const std::string& name, const std::string& content) {
    TextFile file(root_ + "/" + name);
    file.write(content);
    file.close();
}

void AslLog::commit() {
    if (::syncfs(folder_) != 0) {  // the images
        throw InputError(fmt::format("{}: cannot be written: {}", root_, std::strerror(errno)));
    }
    // Images last: whenever the process is killed, every image named has its inertial samples. A table that does not
    // fit any more keeps no other from the disc.
    std::exception_ptr failure;
    for (AppendFile* rows :
         {edges_.get(), ranges_.get(), imu_.get(), pairs_.get(), cameras_[1].get(), cameras_[0].get()}) {
        try {
            if (rows != nullptr) {
                rows->commit();
            }
        } catch (const InputError&) {
            failure = failure ? failure : std::current_exception();
        }
    }
    if (failure) {
        std::rethrow_exception(failure);
    }
}

}  // namespace facet
