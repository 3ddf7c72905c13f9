// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/topic_choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "app/support/input_error.h"

namespace facet {
namespace {

using Names = std::vector<std::string>;
using Pairs = std::vector<std::pair<std::string, std::string>>;

bool fits(LogTable table, RosKind kind) {
    return is_camera(table)          ? kind == RosKind::kImage || kind == RosKind::kCompressedImage
           : table == LogTable::kImu ? kind == RosKind::kImu
                                     : kind == RosKind::kPose;
}

bool contains_any(const std::string& name, std::initializer_list<const char*> words) {
    return std::ranges::any_of(words, [&](const char* word) { return name.find(word) != std::string::npos; });
}

/// Whether the second name is the first's with right for left, or with a number one higher in one place or more.
bool is_pair(const std::string& left, const std::string& right) {
    for (const auto& [from, to] : {std::pair{"left", "right"}, std::pair{"Left", "Right"}, std::pair{"_l", "_r"}}) {
        std::string swapped = left;
        for (std::size_t at = swapped.find(from); at != std::string::npos;
             at = swapped.find(from, at + std::string_view(to).size())) {
            swapped.replace(at, std::string_view(from).size(), to);
        }
        if (swapped != left && swapped == right) {
            return true;
        }
    }
    if (left.size() != right.size() || left == right) {
        return false;
    }
    for (std::size_t i = 0; i < left.size(); ++i) {
        const bool is_next = left[i] >= '0' && left[i] < '9' && right[i] == left[i] + 1;
        if (left[i] != right[i] && !is_next) {
            return false;
        }
    }
    return true;
}

class TopicChoice {
public:
    TopicChoice(const BagSurvey& survey, const TopicWishes& wishes) : survey_(survey), wishes_(wishes) {}

    ChosenTopics choose() {
        chosen_.tables = wishes_.tables;
        split_wish();
        for (const LogTable table : kLogTables) {
            check_named(table, of(table));
        }
        check_named(LogTable::kImu, chosen_.accelerometer);
        choose_cameras();
        choose_imu();
        choose_truth();
        return chosen_;
    }

private:
    std::string& of(LogTable table) { return chosen_.tables[static_cast<std::size_t>(table)]; }
    const TopicSurvey& topic(const std::string& name) const { return survey_.topics.at(name); }

    /// Of images that are recorded in both forms, only the uncompressed ones.
    Names candidates(LogTable table) const {
        Names names;
        for (const auto& [name, topic] : survey_.topics) {
            const std::string raw = name.substr(0, name.rfind('/'));
            const bool is_copy = topic.kind == RosKind::kCompressedImage && survey_.topics.contains(raw);
            if (fits(table, topic.kind) && !is_copy) {
                names.push_back(name);
            }
        }
        return names;
    }

    [[noreturn]] void fail(const std::string& what) const {
        for (const auto& [name, topic] : survey_.topics) {
            const std::string size =
                topic.width == 0 ? "" : fmt::format(", {}x{} {}", topic.width, topic.height, topic.encoding);
            wishes_.warn(fmt::format("topic {}: {}, {} messages at {:.1f} Hz{}", name, topic.type, topic.count,
                                     topic.rate_hz(), size));
        }
        Names names;
        for (const auto& [name, topic] : survey_.topics) {
            names.push_back(name);
        }
        throw InputError(fmt::format("{}: {}; of the types that a log can use it has: {}", wishes_.bag, what,
                                     names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
    }

    /// --imu GYROSCOPE,ACCELEROMETER.
    void split_wish() {
        std::string& imu = of(LogTable::kImu);
        if (const std::size_t comma = imu.find(','); comma != std::string::npos) {
            chosen_.accelerometer = imu.substr(comma + 1);
            imu.erase(comma);
        }
    }
    void check_named(LogTable table, const std::string& name) const {
        const auto found = survey_.topics.find(name);
        if (!name.empty() && (found == survey_.topics.end() || !fits(table, found->second.kind))) {
            fail(fmt::format("there is no topic {} for {}", name, names_of(table).folder));
        }
    }

    void choose_cameras() {
        std::string& left = of(LogTable::kLeft);
        std::string& right = of(LogTable::kRight);
        if (left.empty() && !right.empty()) {
            fail("--right needs --left");
        }
        if (wishes_.is_side_by_side && !right.empty()) {
            fail("--side-by-side needs no --right");
        }
        if (!left.empty()) {
            return;
        }
        Names names = candidates(LogTable::kLeft);
        const auto is_depth = [](const std::string& name) { return contains_any(name, {"depth", "disparity"}); };
        if (!std::ranges::all_of(names, is_depth)) {
            std::erase_if(names, is_depth);
        }
        if (names.size() == 1 || (names.size() == 2 && !wishes_.is_side_by_side)) {
            left = names.front();
            right = names.size() == 2 ? names.back() : "";
            return;
        }
        const Pairs pairs = wishes_.is_side_by_side ? Pairs{} : clear_pairs(names);
        if (pairs.size() != 1) {
            const std::string example = names.size() < 2 ? ""
                                                         : fmt::format(", for example --left {} --right {}",
                                                                       pairs.empty() ? names[0] : pairs[0].first,
                                                                       pairs.empty() ? names[1] : pairs[0].second);
            fail(fmt::format("has {} topics of images; say --left and --right{}", names.size(), example));
        }
        left = pairs[0].first;
        right = pairs[0].second;
        wishes_.warn(fmt::format("of {} topics of images {} and {} are taken; --left and --right name others",
                                 names.size(), left, right));
    }

    /// Pairs of left and right; if there are several, those of raw and grey images.
    static Pairs clear_pairs(const Names& names) {
        Pairs pairs;
        for (const std::string& left : names) {
            for (const std::string& right : names) {
                if (is_pair(left, right)) {
                    pairs.emplace_back(left, right);
                }
            }
        }
        const auto drop = [&](std::initializer_list<const char*> words) {
            Pairs kept;
            std::ranges::copy_if(pairs, std::back_inserter(kept),
                                 [&](const auto& pair) { return !contains_any(pair.first, words); });
            if (!kept.empty()) {
                pairs = kept;
            }
        };
        drop({"compressed"});
        drop({"rect"});
        drop({"color", "colour", "rgb"});
        return pairs;
    }

    void choose_imu() {
        std::string& imu = of(LogTable::kImu);
        const Names names = candidates(LogTable::kImu);
        Names whole;
        Names rates;
        Names forces;
        for (const std::string& name : names) {
            const TopicSurvey& t = topic(name);
            (t.has_rates == t.has_forces ? whole : (t.has_rates ? rates : forces)).push_back(name);
        }
        if (imu.empty() && names.size() == 1) {
            imu = names.front();
        } else if (imu.empty() && whole.size() == 1) {
            imu = whole.front();
        } else if (imu.empty() && whole.empty() && rates.size() == 1 && forces.size() == 1) {
            imu = rates.front();
        } else if (imu.empty()) {
            fail(fmt::format("has {} topics of inertial samples; say --imu", names.size()));
        }
        if (!chosen_.accelerometer.empty()) {
            return;
        }
        // A gyroscope alone is completed by the only accelerometer, and the other way round.
        const TopicSurvey& t = topic(imu);
        if (!t.has_forces && t.has_rates) {
            if (forces.size() != 1) {
                fail(fmt::format("{} has angular rates alone: say --imu {},TOPIC with the accelerometer's topic", imu,
                                 imu));
            }
            chosen_.accelerometer = forces.front();
        } else if (t.has_forces && !t.has_rates && rates.size() == 1) {
            chosen_.accelerometer = std::exchange(imu, rates.front());
        }
    }

    void choose_truth() {
        const Names names = candidates(LogTable::kTruth);
        if (of(LogTable::kTruth).empty() && names.size() == 1) {
            of(LogTable::kTruth) = names.front();
        } else if (of(LogTable::kTruth).empty() && names.size() > 1) {
            wishes_.warn(fmt::format("no ground truth: --groundtruth must say which of {}", fmt::join(names, ", ")));
        }
    }

    const BagSurvey& survey_;
    const TopicWishes& wishes_;
    ChosenTopics chosen_;
};

}  // namespace

ChosenTopics choose_topics(const BagSurvey& survey, const TopicWishes& wishes) {
    return TopicChoice(survey, wishes).choose();
}

}  // namespace facet
