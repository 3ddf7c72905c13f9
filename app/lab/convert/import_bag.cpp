// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/import_bag.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "app/calibration/calibration.h"
#include "app/lab/convert/bag.h"
#include "app/lab/convert/bag_calibration.h"
#include "app/lab/convert/bag_survey.h"
#include "app/lab/convert/grey_image.h"
#include "app/lab/convert/log_table.h"
#include "app/lab/convert/ros_messages.h"
#include "app/lab/convert/split_imu.h"
#include "app/lab/convert/topic_choice.h"
#include "app/lab/convert/unpack_log.h"
#include "app/mcap/bytes.h"
#include "app/support/input_error.h"
#include "drivers/replay_asl/image_decoder.h"

namespace facet {
namespace {

constexpr std::string_view kPngBegin = "\x89PNG";

/// What the survey has decided.
struct ImportPlan {
    ChosenTopics topics;
    unsigned bits = 16;
    std::int64_t inertial_shift_ns = 0;
};

/// A table, and whether something of its topic had to be left out.
struct Table : LogTableFile {
    using LogTableFile::LogTableFile;
    bool is_warned = false;
};

class Importer {
public:
    Importer(const ImportOptions& options, const ImportPlan& plan) : options_(options), plan_(plan) {
        account_.topics = plan.topics.tables;
        account_.accelerometer = plan.topics.accelerometer;
        account_.bits = static_cast<int>(plan.bits);
        account_.inertial_shift_ns = plan.inertial_shift_ns;
        for (const LogTable kind : kLogTables) {
            const bool is_other_half = kind == LogTable::kRight && options.is_side_by_side;
            if (account_.topics[static_cast<std::size_t>(kind)].empty() && !is_other_half) {
                continue;
            }
            tables_.push_back(std::make_unique<Table>(root(), kind));
        }
    }

    void keep_calibration_of(const BagSurvey& survey);
    ImportAccount run(const std::atomic<bool>& stop);

private:
    std::string root() const { return options_.folder + "/mav0"; }
    bool has_right() const {
        return options_.is_side_by_side || !account_.topics[static_cast<std::size_t>(LogTable::kRight)].empty();
    }
    void add(const BagMessage& message, Table& table);
    void note(const BagMessage& message, const std::string& problem, Table& table);
    std::string add_image(const BagMessage& message, Table& table);
    std::string add_halves(const BagMessage& message, Table& left, Table& right);
    std::string read_grey(const RosImage& image, bool is_compressed);
    std::string write_image_file(const RosImage& image, bool is_compressed, const std::string& path);
    std::string add_imu(const BagMessage& message, Table& table);
    std::string add_half_imu(const BagMessage& message, bool is_gyroscope);
    std::string add_pose(const BagMessage& message, Table& table);
    static std::string add_row(Table& table, std::int64_t stamp_ns, const std::string& row);

    const ImportOptions& options_;
    const ImportPlan& plan_;
    std::vector<std::unique_ptr<Table>> tables_;
    ImageDecoder decoder_;
    GreyImage grey_;
    GreyImage half_;
    SplitImu split_imu_;
    ImportAccount account_;
};

void Importer::keep_calibration_of(const BagSurvey& survey) {
    if (options_.cameras.empty() && !options_.imu.empty()) {
        throw InputError("--imu-calibration: needs --calibration with the cameras' file");
    }
    if (!options_.cameras.empty()) {
        const TopicSurvey& left = survey.topics.at(account_.topics[static_cast<std::size_t>(LogTable::kLeft)]);
        const int abreast = options_.is_side_by_side ? 2 : 1;
        const ImageExtent images{static_cast<int>(left.width) / abreast, static_cast<int>(left.height)};
        account_.remarks = give_calibration(options_.cameras, options_.imu, images, has_right(), root());
        account_.has_calibration = true;
        return;
    }
    Calibration calibration;
    try {
        const std::optional<Calibration> own = calibration_of_bag(survey, plan_.topics, account_.calibration_lack);
        if (!own.has_value() || options_.is_side_by_side) {
            return;
        }
        calibration = *own;
        account_.is_own_calibration = true;
    } catch (const InputError& e) {  // it is there and of no use, which does not make the log so
        account_.calibration_lack = e.what();
        return;
    }
    check_cameras(calibration, options_.bag, has_right());
    keep_calibration(calibration, root());
    account_.remarks = calibration.remarks;
    account_.has_calibration = true;
}

/// The rows' stamps are positive: nobody has set a header whose stamp is not.
std::string Importer::add_row(Table& table, std::int64_t stamp_ns, const std::string& row) {
    if (stamp_ns <= 0) {
        return "has no stamp";
    }
    return table.add(stamp_ns, row) ? "" : "has a stamp that was there before, or is far out of order";
}

std::string Importer::read_grey(const RosImage& image, bool is_compressed) {
    if (!is_compressed) {
        return to_grey(image, plan_.bits, grey_);
    }
    return ok(decoder_.decode(image.data, 0, 0, grey_)) ? "" : decoder_.error();
}

std::string Importer::write_image_file(const RosImage& image, bool is_compressed, const std::string& path) {
    if (is_compressed && text_of(image.data).starts_with(kPngBegin)) {
        write_whole_file(path, image.data);
        return "";
    }
    std::string problem = read_grey(image, is_compressed);
    if (problem.empty()) {
        write_grey_png(path, grey_);
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
    return write_image_file(image, kind_of(message.topic->type) == RosKind::kCompressedImage, table.images() + name);
}

/// Both images of one message.
std::string Importer::add_halves(const BagMessage& message, Table& left, Table& right) {
    RosImage image;
    if (!read_message(message, image)) {
        return "is cut off";
    }
    const std::string name = fmt::format("{}.png", image.stamp_ns);
    if (std::string problem = add_row(left, image.stamp_ns, name); !problem.empty()) {
        return problem;
    }
    static_cast<void>(add_row(right, image.stamp_ns, name));
    if (std::string problem = read_grey(image, kind_of(message.topic->type) == RosKind::kCompressedImage);
        !problem.empty()) {
        return problem;
    }
    if (grey_.width % 2 != 0) {
        return "has an odd width: it does not hold two images";
    }
    for (const bool is_left : {true, false}) {
        take_half(grey_, is_left, half_);
        write_grey_png((is_left ? left : right).images() + name, half_);
    }
    return "";
}

/// @return why an inertial message cannot be used; empty if it can
std::string read_imu(const BagMessage& message, RosImu& imu) {
    if (!read_message(message, imu)) {
        return "is cut off";
    }
    if (!std::ranges::all_of(imu.values, [](double x) { return std::isfinite(x); })) {
        return "is not finite";
    }
    return imu.stamp_ns > 0 ? "" : "has no stamp";
}

std::string Importer::add_imu(const BagMessage& message, Table& table) {
    RosImu imu;
    if (std::string problem = read_imu(message, imu); !problem.empty()) {
        return problem;
    }
    return add_row(table, imu.stamp_ns + plan_.inertial_shift_ns, fmt::format("{}", fmt::join(imu.values, ",")));
}

std::string Importer::add_half_imu(const BagMessage& message, bool is_gyroscope) {
    RosImu imu;
    if (std::string problem = read_imu(message, imu); !problem.empty()) {
        return problem;
    }
    const auto& v = imu.values;
    const std::int64_t stamp_ns = imu.stamp_ns + plan_.inertial_shift_ns;
    if (is_gyroscope) {
        split_imu_.add_rates({stamp_ns, {v[0], v[1], v[2]}});
    } else {
        split_imu_.add_forces({stamp_ns, {v[3], v[4], v[5]}});
    }
    return "";
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
    const bool is_split = !account_.accelerometer.empty();
    switch (table.kind()) {
        case LogTable::kImu:
            note(message,
                 is_split ? add_half_imu(message, message.topic->name != account_.accelerometer)
                          : add_imu(message, table),
                 table);
            break;
        case LogTable::kTruth: note(message, add_pose(message, table), table); break;
        default: note(message, add_image(message, table), table); break;
    }
}

void Importer::note(const BagMessage& message, const std::string& problem, Table& table) {
    const auto number = static_cast<std::size_t>(table.kind());
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
    constexpr auto kImu = static_cast<std::size_t>(LogTable::kImu);
    constexpr auto kRight = static_cast<std::size_t>(LogTable::kRight);
    for (BagMessage message; !stop.load() && bag->next(message);) {
        for (const std::unique_ptr<Table>& table : tables_) {
            const std::string& name = message.topic->name;
            const bool is_its = name == account_.topics[static_cast<std::size_t>(table->kind())];
            if (is_its && options_.is_side_by_side && table->kind() == LogTable::kLeft) {
                note(message, add_halves(message, *table, *tables_[kRight]), *table);
            } else if (is_its || (table->kind() == LogTable::kImu && name == account_.accelerometer && !name.empty())) {
                add(message, *table);
            }
        }
        options_.progress(0.5 + 0.5 * bag->share());
    }
    if (!account_.accelerometer.empty()) {
        const auto table = std::ranges::find(tables_, LogTable::kImu, [](const auto& t) { return t->kind(); });
        account_.rows[kImu] = 0;
        account_.left_out[kImu] += split_imu_.finish([&](std::int64_t stamp_ns, const std::array<double, 6>& values) {
            (*table)->add_next(stamp_ns, values);
            ++account_.rows[kImu];
        });
    }
    if (options_.is_side_by_side) {
        account_.rows[kRight] = account_.rows[static_cast<std::size_t>(LogTable::kLeft)];
    }
    for (const std::unique_ptr<Table>& table : tables_) {
        table->close();
    }
    return account_;
}

/// As many as the greatest sample of both cameras needs, of those that cameras have.
unsigned used_bits(const BagSurvey& survey, const ChosenTopics& topics) {
    unsigned greatest = 0;
    for (const LogTable table : {LogTable::kLeft, LogTable::kRight}) {
        const auto topic = survey.topics.find(topics.tables[static_cast<std::size_t>(table)]);
        greatest = topic == survey.topics.end() ? greatest : std::max(greatest, topic->second.greatest_sample);
    }
    for (const unsigned bits : {10U, 12U, 14U}) {
        if (greatest > 0 && greatest < (1U << bits)) {
            return bits;
        }
    }
    return 16;
}

/// What brings inertial stamps to the images' clock; none if they have time in common.
std::int64_t inertial_shift_ns(const ImportOptions& options, const BagSurvey& survey, const ChosenTopics& topics) {
    const TopicSurvey& images = survey.topics.at(topics.tables[static_cast<std::size_t>(LogTable::kLeft)]);
    const TopicSurvey& imu = survey.topics.at(topics.tables[static_cast<std::size_t>(LogTable::kImu)]);
    const bool has_stamps = images.first_ns > 0 && imu.first_ns > 0;
    if (!has_stamps || (images.first_ns <= imu.last_ns && imu.first_ns <= images.last_ns)) {
        return 0;
    }
    if (!options.align_clocks) {
        throw InputError(no_common_time_text(options.bag, images.first_ns, images.last_ns, imu.first_ns, imu.last_ns));
    }
    // Both were recorded by one clock, if by that they overlap; the quickest message has the least of its delay.
    const std::int64_t by_recorder = imu.least_delay_ns - images.least_delay_ns;
    const bool overlaps = images.first_ns <= imu.last_ns + by_recorder && imu.first_ns + by_recorder <= images.last_ns;
    const std::int64_t shift_ns = overlaps ? by_recorder : images.first_ns - imu.first_ns;
    options.warn(fmt::format("inertial stamps are shifted by {:.3f} s {}: facet check-calibration says what is left",
                             static_cast<double>(shift_ns) * 1e-9,
                             overlaps ? "as the recorder's clock has it, to within the delays of the messages"
                                      : "so that both begin together, which is a guess"));
    return shift_ns;
}

}  // namespace

ImportAccount import_bag(const ImportOptions& options, const std::atomic<bool>& stop) {
    const BagSurvey survey = survey_bag(
        options.bag, options.warn, [&](double share) { options.progress(0.5 * share); }, stop);
    if (stop.load()) {
        return {};
    }
    ImportPlan plan;
    plan.topics = choose_topics(survey, {options.bag, options.topics, options.is_side_by_side, options.warn});
    plan.bits = options.bits > 0 ? static_cast<unsigned>(options.bits) : used_bits(survey, plan.topics);
    plan.inertial_shift_ns = inertial_shift_ns(options, survey, plan.topics);
    make_empty_folder(options.folder);
    Importer importer(options, plan);
    importer.keep_calibration_of(survey);
    return importer.run(stop);
}

}  // namespace facet
