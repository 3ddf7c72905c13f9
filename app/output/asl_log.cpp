// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/asl_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "app/support/input_error.h"
#include "app/support/png_writer.h"
#include "app/support/text_file.h"

namespace facet {
namespace {

constexpr const char* kImageHeader = "#timestamp [ns],filename\n";
constexpr const char* kImuHeader =
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m "
    "s^-2],a_RS_S_z [m s^-2]\n";
constexpr const char* kPairHeader =
    "#timestamp [ns],left_stamp [ns],right_stamp [ns],left_sequence,right_sequence,left_exposure "
    "[ns],right_exposure [ns]\n";
constexpr const char* kEdgeHeader = "#timestamp [ns],sequence,rising\n";

}  // namespace

RowFile::RowFile(std::string path, const std::string& header)
    : path_(std::move(path)),
      rows_(header),
      descriptor_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)) {
    if (descriptor_ < 0) {
        fail(errno);
    }
}

RowFile::~RowFile() {
    if (descriptor_ >= 0) {
        ::close(descriptor_);
    }
}

void RowFile::fail(int error) const {
    throw InputError(fmt::format("{}: cannot be written: {}", path_, std::strerror(error)));
}

void RowFile::commit() {
    std::size_t done = 0;
    while (done < rows_.size()) {
        const ssize_t count = ::write(descriptor_, rows_.data() + done, rows_.size() - done);
        if (count < 0 && errno == EINTR) {
            continue;
        }
        if (count <= 0) {
            const int error = errno;
            const std::size_t whole = done == 0 ? 0 : rows_.rfind('\n', done - 1) + 1;  // npos + 1 is 0
            size_ += static_cast<off_t>(whole);
            rows_.erase(0, whole);
            (void)::ftruncate(descriptor_, size_);
            (void)::lseek(descriptor_, size_, SEEK_SET);
            fail(error);
        }
        done += static_cast<std::size_t>(count);
    }
    size_ += static_cast<off_t>(done);
    rows_.clear();
    if (::fdatasync(descriptor_) != 0) {
        fail(errno);
    }
}

AslLog::AslLog(const std::string& folder, bool has_right) : root_(folder + "/mav0") {
    if (std::filesystem::exists(root_)) {
        throw InputError(root_ + ": there is a log already");
    }
    make_folder(root_ + "/cam0/data");
    make_folder(root_ + "/imu0");
    make_folder(root_ + "/trigger0");
    cameras_[0] = std::make_unique<RowFile>(root_ + "/cam0/data.csv", kImageHeader);
    if (has_right) {
        make_folder(root_ + "/cam1/data");
        cameras_[1] = std::make_unique<RowFile>(root_ + "/cam1/data.csv", kImageHeader);
    }
    imu_ = std::make_unique<RowFile>(root_ + "/imu0/data.csv", kImuHeader);
    pairs_ = std::make_unique<RowFile>(root_ + "/pairs.csv", kPairHeader);
    edges_ = std::make_unique<RowFile>(root_ + "/trigger0/data.csv", kEdgeHeader);
    folder_ = ::open(root_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    commit();
}

AslLog::~AslLog() {
    if (folder_ >= 0) {
        ::close(folder_);
    }
}

void AslLog::add_image(int camera, Timestamp stamp, const ImageView& image) {
    RowFile* const rows = cameras_[static_cast<std::size_t>(camera)].get();
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
    pairs_->add(fmt::format("{},{},{},{},{},{},{}\n", origin.stamp.ns, origin.camera_stamp[0].ns,
                            origin.camera_stamp[1].ns, origin.sequence[0], origin.sequence[1], origin.exposure[0].ns,
                            origin.exposure[1].ns));
}

void AslLog::add_imu(const ImuSample& sample) {
    const Eigen::Vector3d& w = sample.w_B;
    const Eigen::Vector3d& a = sample.a_B;
    // The shortest text that reads back as the same double.
    imu_->add(fmt::format("{},{},{},{},{},{},{}\n", sample.stamp.ns, w.x(), w.y(), w.z(), a.x(), a.y(), a.z()));
}

void AslLog::add_edge(const TriggerEdge& edge) {
    edges_->add(fmt::format("{},{},{}\n", edge.stamp.ns, edge.sequence, edge.rising ? 1 : 0));
}

void AslLog::commit() {
    if (::syncfs(folder_) != 0) {  // the images
        throw InputError(fmt::format("{}: cannot be written: {}", root_, std::strerror(errno)));
    }
    for (RowFile* rows : {cameras_[0].get(), cameras_[1].get(), imu_.get(), pairs_.get(), edges_.get()}) {
        if (rows != nullptr) {
            rows->commit();
        }
    }
}

}  // namespace facet
