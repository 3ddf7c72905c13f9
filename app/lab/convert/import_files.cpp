// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/import_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "app/lab/convert/image_list.h"
#include "app/lab/convert/inertial_table.h"
#include "app/lab/convert/log_table.h"
#include "app/lab/convert/unpack_log.h"
#include "app/lab/convert/video_file.h"
#include "app/support/input_error.h"
#include "drivers/replay_asl/image_decoder.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

bool is_listed(const std::string& path) { return fs::is_directory(path) || is_text_file(path); }

/// One camera's images: files, or a video.
struct CameraSource {
    std::string name;
    std::vector<StampedFile> files;
    std::unique_ptr<VideoFile> video;
    std::vector<std::int64_t> stamps_ns;  ///< of all images, in order
    bool has_own_clock = false;           ///< stamps are those of a video's container
};

CameraSource open_source(const std::string& path, const std::string& stamps, ImageList& list) {
    CameraSource source;
    source.name = path;
    if (is_listed(path)) {
        list = read_image_list(path, stamps);
        source.files = std::move(list.left);
        std::ranges::transform(source.files, std::back_inserter(source.stamps_ns), &StampedFile::stamp_ns);
        return source;
    }
    source.video = std::make_unique<VideoFile>(path);
    source.stamps_ns = source.video->stamps_ns();
    if (!stamps.empty()) {
        const std::vector<std::int64_t> all = read_stamps(stamps);
        if (all.size() != source.stamps_ns.size()) {
            throw InputError(fmt::format("{}: has {} stamps, but {} has {} frames", stamps, all.size(), path,
                                         source.stamps_ns.size()));
        }
        source.stamps_ns = all;
    } else if (!source.video->has_stamps()) {
        throw InputError(path + ": has no time stamps of its own: --stamps FILE names a table with one for each frame");
    } else {
        source.has_own_clock = true;
    }
    return source;
}

class FilesImporter {
public:
    FilesImporter(const FilesOptions& options, const std::atomic<bool>& stop) : options_(options), stop_(stop) {}

    FilesAccount run();

private:
    std::string root() const { return options_.folder + "/mav0"; }
    bool has_right() const { return sources_.size() > 1 || options_.is_side_by_side; }
    void open_sources();
    void write_inertial(const InertialTable& imu);
    std::int64_t align(const InertialTable& imu);
    void write_images(CameraSource& source, std::size_t camera);
    void add_file(const StampedFile& file, std::size_t camera);
    void add_frame(std::int64_t stamp_ns, const GreyImage& image, std::size_t camera);
    void leave_out(std::size_t camera, const std::string& why);
    void note_size(int width, int height) {
        extent_ = extent_.width > 0 ? extent_ : ImageExtent{options_.is_side_by_side ? width / 2 : width, height};
    }

    const FilesOptions& options_;
    const std::atomic<bool>& stop_;
    std::vector<CameraSource> sources_;
    std::vector<std::unique_ptr<LogTableFile>> tables_;  ///< of cameras
    std::array<bool, 2> is_warned_{};
    ImageDecoder decoder_;
    GreyImage grey_;
    GreyImage half_;
    ImageExtent extent_;
    std::size_t total_ = 1;
    std::size_t done_ = 0;
    FilesAccount account_;
};

void FilesImporter::open_sources() {
    ImageList list;
    sources_.push_back(open_source(options_.images[0], options_.stamps[0], list));
    if (!list.right.empty() && options_.images[1].empty() && !options_.is_side_by_side) {
        CameraSource right;
        right.name = options_.images[0];
        right.files = std::move(list.right);
        right.stamps_ns = sources_[0].stamps_ns;
        sources_.push_back(std::move(right));
    } else if (!options_.images[1].empty()) {
        if (options_.is_side_by_side) {
            throw InputError("--side-by-side: each image of one file holds both; --right is another one");
        }
        const std::string& stamps = options_.stamps[1].empty() ? options_.stamps[0] : options_.stamps[1];
        sources_.push_back(open_source(options_.images[1], stamps, list));
    }
    total_ = 0;
    for (const CameraSource& source : sources_) {
        if (source.stamps_ns.empty()) {
            throw InputError(source.name + ": holds no image");
        }
        total_ += source.stamps_ns.size();
        account_.is_video = account_.is_video || source.video != nullptr;
    }
}

/// @return what is to be added to inertial stamps; those of a video's container are moved instead, onto the IMU's clock
std::int64_t FilesImporter::align(const InertialTable& imu) {
    const std::vector<std::int64_t>& stamps = sources_[0].stamps_ns;
    const std::int64_t imu_first = imu.samples.front().stamp_ns;
    const std::int64_t imu_last = imu.samples.back().stamp_ns;
    if (stamps.front() <= imu_last && imu_first <= stamps.back()) {
        return 0;
    }
    if (!options_.align_clocks) {
        throw InputError(no_common_time_text(options_.images[0], stamps.front(), stamps.back(), imu_first, imu_last) +
                         (sources_[0].has_own_clock
                              ? "; --stamps FILE names a table with the frames' stamps by the IMU's clock"
                              : ""));
    }
    const std::int64_t shift_ns = stamps.front() - imu_first;
    options_.warn(
        fmt::format("{} are shifted by {:.3f} s so that both begin together, which is a guess: facet "
                    "check-calibration says what is left of it, within 0.15 s",
                    sources_[0].has_own_clock ? "frames" : "inertial stamps",
                    static_cast<double>(sources_[0].has_own_clock ? -shift_ns : shift_ns) * 1e-9));
    if (!sources_[0].has_own_clock) {
        return shift_ns;
    }
    for (CameraSource& source : sources_) {
        for (std::int64_t& stamp_ns : source.stamps_ns) {
            stamp_ns -= shift_ns;
        }
    }
    return 0;
}

void FilesImporter::write_inertial(const InertialTable& imu) {
    const std::int64_t shift_ns = align(imu);
    LogTableFile table(root(), LogTable::kImu);
    for (const InertialSample& sample : imu.samples) {
        table.add_next(sample.stamp_ns + shift_ns, sample.values);
    }
    table.close();
    account_.samples = imu.samples.size();
    account_.samples_left_out = imu.left_out;
}

void FilesImporter::leave_out(std::size_t camera, const std::string& why) {
    ++account_.left_out[camera];
    if (!is_warned_[camera]) {
        is_warned_[camera] = true;
        options_.warn(why + "; left out, as others of its kind will be");
    }
}

/// Both halves belong to the left source.
void FilesImporter::add_frame(std::int64_t stamp_ns, const GreyImage& image, std::size_t camera) {
    note_size(image.width, image.height);
    if (options_.is_side_by_side && image.width % 2 != 0) {
        leave_out(camera, fmt::format("the image at {} ns has an odd width: it does not hold two", stamp_ns));
        return;
    }
    const std::string name = fmt::format("{}.png", stamp_ns);
    for (std::size_t side = camera; side <= (options_.is_side_by_side ? 1 : camera); ++side) {
        if (!tables_[side]->add(stamp_ns, name)) {
            leave_out(side, fmt::format("the image at {} ns has a stamp that was there before", stamp_ns));
            continue;
        }
        if (options_.is_side_by_side) {
            take_half(image, side == 0, half_);
        }
        write_grey_png(tables_[side]->images() + name, options_.is_side_by_side ? half_ : image);
        ++account_.images[side];
    }
}

void FilesImporter::add_file(const StampedFile& file, std::size_t camera) {
    const bool decodes = options_.is_side_by_side || extent_.width == 0;
    if (decodes && !ok(decoder_.decode(file.path, 0, 0, grey_))) {
        leave_out(camera, file.path + ": " + decoder_.error());
        return;
    }
    if (options_.is_side_by_side) {
        add_frame(file.stamp_ns, grey_, camera);
        return;
    }
    if (decodes) {
        note_size(grey_.width, grey_.height);
    }
    if (!is_image_file(file.path)) {
        leave_out(camera, file.path + (fs::exists(file.path) ? ": is not an image" : ": is not there"));
        return;
    }
    const std::string name = std::to_string(file.stamp_ns) + fs::path(file.path).extension().string();
    if (!tables_[camera]->add(file.stamp_ns, name)) {
        leave_out(camera, file.path + ": has a stamp that was there before");
        return;
    }
    std::error_code error;
    fs::copy_file(file.path, tables_[camera]->images() + name, error);
    if (error) {
        throw InputError(tables_[camera]->images() + name + ": cannot be written: " + error.message());
    }
    ++account_.images[camera];
}

void FilesImporter::write_images(CameraSource& source, std::size_t camera) {
    const auto tell = [&] { options_.progress(static_cast<double>(++done_) / static_cast<double>(total_)); };
    for (std::size_t i = 0; i < source.files.size() && !stop_.load(); ++i, tell()) {
        source.files[i].stamp_ns = source.stamps_ns[i];
        add_file(source.files[i], camera);
    }
    std::size_t number = 0;
    std::size_t next = 0;
    while (source.video != nullptr && !stop_.load() && source.video->next(number, grey_)) {
        for (; next < number; ++next, tell()) {
            leave_out(camera, fmt::format("{}: frame {} is damaged", source.name, next));
        }
        add_frame(source.stamps_ns[number], grey_, camera);
        next = number + 1;
        tell();
    }
    for (; source.video != nullptr && !stop_.load() && next < source.stamps_ns.size(); ++next) {
        leave_out(camera, fmt::format("{}: frame {} is damaged", source.name, next));
    }
}

FilesAccount FilesImporter::run() {
    if (options_.imu.empty()) {
        throw InputError(options_.images[0] +
                         ": images without inertial samples: --imu FILE names a table of them (stamp, angular rate x y "
                         "z, specific force x y z)");
    }
    if (options_.cameras.empty() && !options_.imu_calibration.empty()) {
        throw InputError("--imu-calibration: needs --calibration with the cameras' file");
    }
    open_sources();
    const InertialTable imu = read_inertial_table(options_.imu, options_.warn);
    make_empty_folder(options_.folder);
    write_inertial(imu);
    for (std::size_t camera = 0; camera < (has_right() ? 2U : 1U); ++camera) {
        tables_.push_back(std::make_unique<LogTableFile>(root(), camera == 0 ? LogTable::kLeft : LogTable::kRight));
    }
    for (std::size_t camera = 0; camera < sources_.size(); ++camera) {
        write_images(sources_[camera], camera);
    }
    for (const std::unique_ptr<LogTableFile>& table : tables_) {
        table->close();
    }
    if (!options_.cameras.empty() && !stop_.load()) {
        account_.remarks = give_calibration(options_.cameras, options_.imu_calibration, extent_, has_right(), root());
        account_.has_calibration = true;
    }
    return account_;
}

}  // namespace

bool is_image_source(const std::string& path) {
    if (fs::is_directory(path)) {
        return std::ranges::any_of(fs::directory_iterator(path), [](const fs::directory_entry& entry) {
            return entry.is_regular_file() && is_image_file(entry.path().string());
        });
    }
    if (is_text_file(path)) {
        return is_image_list(path);
    }
    return fs::is_regular_file(path) && VideoFile::recognises(path);
}

std::string image_source_in(const std::string& folder) {
    std::string first;
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
        const std::string path = entry.path().string();
        if ((first.empty() || path < first) && is_image_source(path)) {
            first = path;
        }
    }
    return first;
}

FilesAccount import_files(const FilesOptions& options, const std::atomic<bool>& stop) {
    return FilesImporter(options, stop).run();
}

}  // namespace facet
