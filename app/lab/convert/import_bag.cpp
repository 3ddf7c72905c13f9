// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/import_bag.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "app/calibration/calibration.h"
#include "app/lab/convert/bag.h"
#include "app/lab/convert/grey_image.h"
#include "app/lab/convert/ros_messages.h"
#include "app/lab/convert/sorted_rows.h"
#include "app/lab/convert/unpack_log.h"
#include "app/mcap/bytes.h"
#include "app/support/input_error.h"
#include "app/support/png_writer.h"
#include "app/support/text_file.h"

namespace facet {
namespace {

constexpr std::string_view kPngBegin = "\x89PNG";
constexpr std::string_view kJpegBegin = "\xFF\xD8\xFF";

const char* header_of(LogTable table) {
    switch (table) {
        case LogTable::kImu:
            return "#timestamp [ns],w_x [rad s^-1],w_y [rad s^-1],w_z [rad s^-1],a_x [m s^-2],a_y [m s^-2],"
                   "a_z [m s^-2]\n";
        case LogTable::kTruth: return "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
        default: return "#timestamp [ns],filename\n";
    }
}

/// Topics of a bag that a log can use, by name.
using Topics = std::map<std::string, RosKind>;

Topics find_topics(const ImportOptions& options, const std::atomic<bool>& stop) {
    const std::unique_ptr<Bag> bag = open_bag(options.bag, options.warn, &stop);
    Topics topics;
    for (BagMessage message; !stop.load() && bag->next(message);) {
        if (const std::optional<RosKind> kind = kind_of(message.topic->type)) {
            topics.try_emplace(message.topic->name, *kind);
        }
        options.progress(0.5 * bag->share());
    }
    return topics;
}

bool fits(LogTable table, RosKind kind) {
    return is_camera(table)          ? kind == RosKind::kImage || kind == RosKind::kCompressedImage
           : table == LogTable::kImu ? kind == RosKind::kImu
                                     : kind == RosKind::kPose;
}

/// Topics that a table can be made of. Of images that are recorded in both forms, only the uncompressed ones.
std::vector<std::string> candidates(const Topics& topics, LogTable table) {
    std::vector<std::string> names;
    for (const auto& [name, kind] : topics) {
        const std::string raw = name.substr(0, name.rfind('/'));
        const bool is_copy = kind == RosKind::kCompressedImage && topics.contains(raw);
        if (fits(table, kind) && !is_copy) {
            names.push_back(name);
        }
    }
    return names;
}

/// Which topic becomes which table.
class TopicChoice {
public:
    TopicChoice(const ImportOptions& options, const Topics& topics) : options_(options), topics_(topics) {}

    std::array<std::string, 4> choose() {
        chosen_ = options_.topics;
        for (const LogTable table : kLogTables) {
            check_named(table);
        }
        choose_cameras();
        choose_one(LogTable::kImu, "--imu");
        choose_truth();
        return chosen_;
    }

private:
    std::string& of(LogTable table) { return chosen_[static_cast<std::size_t>(table)]; }

    [[noreturn]] void fail(const std::string& what) const {
        std::vector<std::string> names;
        for (const auto& [name, kind] : topics_) {
            names.push_back(name);
        }
        throw InputError(fmt::format("{}: {}; of the types that a log can use it has: {}", options_.bag, what,
                                     names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
    }
    void check_named(LogTable table) {
        const std::string& name = of(table);
        const auto topic = topics_.find(name);
        if (!name.empty() && (topic == topics_.end() || !fits(table, topic->second))) {
            fail(fmt::format("there is no topic {} for {}", name, names_of(table).folder));
        }
    }
    void choose_cameras() {
        const std::vector<std::string> names = candidates(topics_, LogTable::kLeft);
        std::string& left = of(LogTable::kLeft);
        std::string& right = of(LogTable::kRight);
        if (left.empty() && !right.empty()) {
            fail("--right needs --left");
        }
        if (!left.empty()) {
            return;
        }
        if (names.empty() || names.size() > 2) {
            fail(fmt::format("has {} topics of images; say --left and --right", names.size()));
        }
        left = names.front();
        right = names.size() == 2 ? names.back() : "";
    }
    void choose_one(LogTable table, const char* option) {
        const std::vector<std::string> names = candidates(topics_, table);
        if (of(table).empty() && names.size() != 1) {
            fail(fmt::format("has {} topics of inertial samples; say {}", names.size(), option));
        }
        of(table) = of(table).empty() ? names.front() : of(table);
    }
    void choose_truth() {
        const std::vector<std::string> names = candidates(topics_, LogTable::kTruth);
        if (of(LogTable::kTruth).empty() && names.size() == 1) {
            of(LogTable::kTruth) = names.front();
        } else if (of(LogTable::kTruth).empty() && names.size() > 1) {
            options_.warn(fmt::format("no ground truth: --groundtruth must say which of {}", fmt::join(names, ", ")));
        }
    }

    const ImportOptions& options_;
    const Topics& topics_;
    std::array<std::string, 4> chosen_;
};

/// A table that is being written.
struct Table {
    Table(const std::string& folder, LogTable which)
        : kind(which),
          file(folder + "/data.csv"),
          images(folder + "/data/"),
          rows(kSorted, [this](auto stamp, auto& row) { file.print("{},{}\n", stamp, row); }) {
        file.write(header_of(which));
    }

    LogTable kind;
    TextFile file;
    std::string images;  ///< folder of them
    SortedRows rows;
    bool is_warned = false;
};

class Importer {
public:
    Importer(const ImportOptions& options, const std::array<std::string, 4>& topics) : options_(options) {
        account_.topics = topics;
        const std::string root = options.folder + "/mav0";
        for (const LogTable kind : kLogTables) {
            const std::string& topic = topics[static_cast<std::size_t>(kind)];
            if (topic.empty()) {
                continue;
            }
            const std::string folder = root + "/" + names_of(kind).folder;
            make_folder(is_camera(kind) ? folder + "/data" : folder);
            tables_.push_back(std::make_unique<Table>(folder, kind));
        }
        keep_calibration_in(root);
    }

    ImportAccount run(const std::atomic<bool>& stop);

private:
    void keep_calibration_in(const std::string& root);
    void add(const BagMessage& message, Table& table);
    std::string add_image(const BagMessage& message, Table& table);
    std::string write_image_file(const RosImage& image, bool is_compressed, const std::string& path);
    std::string add_imu(const BagMessage& message, Table& table);
    std::string add_pose(const BagMessage& message, Table& table);
    static std::string add_row(Table& table, std::int64_t stamp_ns, const std::string& row);

    const ImportOptions& options_;
    std::vector<std::unique_ptr<Table>> tables_;
    GreyImage grey_;
    ImportAccount account_;
};

void Importer::keep_calibration_in(const std::string& root) {
    if (options_.cameras.empty() && options_.imu.empty()) {
        return;
    }
    if (options_.cameras.empty() || (std::filesystem::is_regular_file(options_.cameras) && options_.imu.empty())) {
        throw InputError("Kalibr's calibration is two files: --calibration camchain.yaml --imu-calibration imu.yaml");
    }
    const Calibration calibration = load_calibration(options_.cameras, options_.cameras, options_.imu);
    if (calibration.files.empty()) {
        throw InputError("--calibration and --imu-calibration must both be of EuRoC's kind or both of Kalibr's");
    }
    const bool has_right = !account_.topics[static_cast<std::size_t>(LogTable::kRight)].empty();
    if (calibration.rig.has_right != has_right) {
        throw InputError(fmt::format("{}: is a calibration of {}, but the log gets {}", options_.cameras,
                                     calibration.rig.has_right ? "two cameras" : "one camera",
                                     has_right ? "two" : "one"));
    }
    keep_calibration(calibration, root);
    account_.has_calibration = true;
}

/// The rows' stamps are positive: nobody has set a header whose stamp is not.
std::string Importer::add_row(Table& table, std::int64_t stamp_ns, const std::string& row) {
    if (stamp_ns <= 0) {
        return "has no stamp";
    }
    return table.rows.add(stamp_ns, row) ? "" : "has a stamp that was there before, or is far out of order";
}

std::string Importer::write_image_file(const RosImage& image, bool is_compressed, const std::string& path) {
    if (is_compressed && text_of(image.data).starts_with(kPngBegin)) {
        write_whole_file(path, image.data);
        return "";
    }
    std::string problem;
    if (!is_compressed) {
        problem = to_grey(image, grey_);
    } else if (text_of(image.data).starts_with(kJpegBegin)) {
        problem = read_jpeg(image.data, grey_);
    } else {
        problem = "is neither PNG nor JPEG";
    }
    if (problem.empty() && !ok(write_png(path, grey_.view()))) {
        throw InputError(path + ": cannot be written");
    }
    return problem;
}

std::string Importer::add_image(const BagMessage& message, Table& table) {
    RosImage image;
    if (!read_message(message, image)) {
        return "is cut off";
    }
    const std::string name = fmt::format("{}.png", image.stamp_ns);
    if (std::string problem = add_row(table, image.stamp_ns, name); !problem.empty()) {
        return problem;
    }
    // A row whose image could not be made stays: the log lacks an image then, which its reader says.
    return write_image_file(image, kind_of(message.topic->type) == RosKind::kCompressedImage, table.images + name);
}

std::string Importer::add_imu(const BagMessage& message, Table& table) {
    RosImu imu;
    if (!read_message(message, imu)) {
        return "is cut off";
    }
    if (!std::ranges::all_of(imu.values, [](double x) { return std::isfinite(x); })) {
        return "is not finite";
    }
    return add_row(table, imu.stamp_ns, fmt::format("{}", fmt::join(imu.values, ",")));
}

std::string Importer::add_pose(const BagMessage& message, Table& table) {
    RosPose pose;
    if (!read_message(message, pose)) {
        return "is cut off";
    }
    if (!std::ranges::all_of(pose.values, [](double x) { return std::isfinite(x); })) {
        return "is not finite";
    }
    return add_row(table, pose.stamp_ns, fmt::format("{}", fmt::join(pose.values, ",")));
}

void Importer::add(const BagMessage& message, Table& table) {
    std::string problem;
    switch (table.kind) {
        case LogTable::kImu: problem = add_imu(message, table); break;
        case LogTable::kTruth: problem = add_pose(message, table); break;
        default: problem = add_image(message, table); break;
    }
    const auto number = static_cast<std::size_t>(table.kind);
    ++(problem.empty() ? account_.rows : account_.left_out)[number];
    if (!problem.empty() && !table.is_warned) {
        table.is_warned = true;
        options_.warn(fmt::format("{}: a message recorded at {} ns {}; left out, as others of its kind will be",
                                  message.topic->name, message.time_ns, problem));
    }
}

ImportAccount Importer::run(const std::atomic<bool>& stop) {
    // Warnings about the file itself have been given when the topics were looked for.
    const std::unique_ptr<Bag> bag = open_bag(
        options_.bag, [](const std::string&) {}, &stop);
    for (BagMessage message; !stop.load() && bag->next(message);) {
        for (const std::unique_ptr<Table>& table : tables_) {
            if (message.topic->name == account_.topics[static_cast<std::size_t>(table->kind)]) {
                add(message, *table);
            }
        }
        options_.progress(0.5 + 0.5 * bag->share());
    }
    for (const std::unique_ptr<Table>& table : tables_) {
        table->rows.finish();
        table->file.close();
    }
    return account_;
}

}  // namespace

ImportAccount import_bag(const ImportOptions& options, const std::atomic<bool>& stop) {
    const Topics topics = find_topics(options, stop);
    if (stop.load()) {
        return {};
    }
    const std::array<std::string, 4> chosen = TopicChoice(options, topics).choose();
    make_empty_folder(options.folder);
    return Importer(options, chosen).run(stop);
}

}  // namespace facet
