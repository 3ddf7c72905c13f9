// SPDX-License-Identifier: BSD-2-Clause
// Which topics of a bag become the tables of a log.
#pragma once

#include <array>
#include <functional>
#include <string>

#include "app/lab/convert/bag_survey.h"
#include "app/mcap/log_messages.h"

namespace facet {

struct ChosenTopics {
    std::array<std::string, 4> tables;  ///< by LogTable; empty: none. Of a split IMU the gyroscope's
    std::string accelerometer;          ///< empty unless accelerometer and gyroscope have a topic each
};

/// What the user has said of it.
struct TopicWishes {
    std::string bag;                    ///< for errors
    std::array<std::string, 4> tables;  ///< by LogTable; empty: to be found. The IMU's may be GYROSCOPE,ACCELEROMETER
    bool is_side_by_side = false;       ///< left and right image in one
    std::function<void(const std::string&)> warn;
};

/// Chooses by types, by what the messages hold, and of several cameras the one pair whose names differ as left and
/// right do. Of images recorded in two forms the uncompressed ones, of raw and rectified ones the raw ones; never
/// depth. What is not the only possibility is reported as a warning.
/// Throws InputError if no choice is clear, with a command to type, after a warning for each topic that there is.
ChosenTopics choose_topics(const BagSurvey& survey, const TopicWishes& wishes);

}  // namespace facet
