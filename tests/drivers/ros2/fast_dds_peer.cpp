// SPDX-License-Identifier: BSD-2-Clause
// The other side of ros2_flight_test.py: drivers of two cameras and an inertial sensor, and whoever listens to
// estimates, by Fast DDS.
//
// fast_dds_peer DATASET DOMAIN   waits until the sensors' topics are subscribed to, plays the log in real time, then
//                                prints a row for each odometry (stamp in the log's time, position, quaternion), and
//                                as JSON what else came
#include <fastdds/dds/core/status/PublicationMatchedStatus.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <thread>

#include "drivers/replay_asl/asl_dataset.h"
#include "tests/drivers/ros2/fast_dds.h"

namespace facet::test {
namespace {

using eprosima::fastcdr::Cdr;
using Clock = std::chrono::system_clock;

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::size_t kRoomForFields = 1024;

std::int64_t now_ns() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
}

void write_header(Cdr& cdr, std::int64_t stamp_ns, const char* frame) {
    cdr << static_cast<std::int32_t>(stamp_ns / kSecond_ns) << static_cast<std::uint32_t>(stamp_ns % kSecond_ns)
        << std::string(frame);
}

std::int64_t read_header(Cdr& cdr, std::string& frame) {
    std::int32_t sec = 0;
    std::uint32_t nanosec = 0;
    cdr >> sec >> nanosec >> frame;
    return sec * kSecond_ns + nanosec;
}

std::vector<double> read_doubles(Cdr& cdr, std::size_t count) {
    std::vector<double> values(count);
    for (double& value : values) {
        cdr >> value;
    }
    return values;
}

/// sensor_msgs/Image; in colour each pixel three times over.
Bytes image_message(std::int64_t stamp_ns, const ImageView& image, bool is_colour) {
    std::vector<std::uint8_t> data;
    data.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * (is_colour ? 3 : 1));
    for (int v = 0; v < image.height; ++v) {
        for (int u = 0; u < image.width; ++u) {
            data.insert(data.end(), is_colour ? 3 : 1, image.at(u, v));
        }
    }
    return to_wire(data.size() + kRoomForFields, [&](Cdr& cdr) {
        write_header(cdr, stamp_ns, "camera");
        cdr << static_cast<std::uint32_t>(image.height) << static_cast<std::uint32_t>(image.width)
            << std::string(is_colour ? "rgb8" : "mono8") << std::uint8_t{0}
            << static_cast<std::uint32_t>(image.width * (is_colour ? 3 : 1)) << data;
    });
}

/// sensor_msgs/Imu without an orientation, as most drivers publish it.
Bytes imu_message(std::int64_t stamp_ns, const ImuSample& s) {
    return to_wire(kRoomForFields, [&](Cdr& cdr) {
        write_header(cdr, stamp_ns, "imu");
        for (const double value : {0.0, 0.0, 0.0, 1.0, -1.0}) {
            cdr << value;
        }
        const auto zeros = [&](int count) {
            for (int i = 0; i < count; ++i) {
                cdr << 0.0;
            }
        };
        zeros(8);
        cdr << s.w_B.x() << s.w_B.y() << s.w_B.z();
        zeros(9);
        cdr << s.a_B.x() << s.a_B.y() << s.a_B.z();
        zeros(9);
    });
}

/// sensor_msgs/CameraInfo with intrinsics that no calibration has.
Bytes info_message(std::int64_t stamp_ns, const ImageView& image) {
    return to_wire(kRoomForFields, [&](Cdr& cdr) {
        write_header(cdr, stamp_ns, "camera");
        cdr << static_cast<std::uint32_t>(image.height) << static_cast<std::uint32_t>(image.width)
            << std::string("plumb_bob") << std::vector<double>(5);
        for (int i = 0; i < 9 + 9 + 12; ++i) {
            cdr << 7.0;
        }
        for (int i = 0; i < 6; ++i) {
            cdr << std::uint32_t{0};
        }
        cdr << false;
    });
}

/// What came from the estimator.
class Listener {
public:
    explicit Listener(FastDds& node) {
        listen(node, "/facet/odometry", "nav_msgs::msg::dds_::Odometry_", [this](Cdr& cdr) { hear_odometry(cdr); });
        listen(node, "/tf", "tf2_msgs::msg::dds_::TFMessage_", [this](Cdr& cdr) { hear_transform(cdr); });
        listen(node, "/diagnostics", "diagnostic_msgs::msg::dds_::DiagnosticArray_",
               [this](Cdr& cdr) { hear_diagnostics(cdr); });
        listen(node, "/facet/mesh", "visualization_msgs::msg::dds_::Marker_",
               [this](Cdr& cdr) { hear_marker(cdr, "mesh"); });
        listen(node, "/facet/planes", "visualization_msgs::msg::dds_::Marker_",
               [this](Cdr& cdr) { hear_marker(cdr, "planes"); });
        listen(node, "/facet/landmarks", "sensor_msgs::msg::dds_::PointCloud2_", [this](Cdr& cdr) { hear_cloud(cdr); });
        listen(node, "/facet/path", "nav_msgs::msg::dds_::Path_", [this](Cdr& cdr) { hear_path(cdr); });
        listen(node, "/facet/grid", "nav_msgs::msg::dds_::OccupancyGrid_", [this](Cdr& cdr) { hear_grid(cdr); });
    }

    /// @param shift_ns  from this computer's time to the log's
    void print(std::int64_t shift_ns) {
        const std::lock_guard lock(mutex_);
        counts_["shift_ns"] = shift_ns;
        for (const Row& row : rows_) {
            std::printf("%lld", static_cast<long long>(row.stamp_ns + shift_ns));
            for (const double value : row.pose) {
                std::printf(",%.12g", value);
            }
            std::printf(",%.3f\n", row.age_ms);
        }
        std::string text;
        for (const auto& [what, count] : counts_) {
            text += (text.empty() ? "" : ", ") + ("\"" + what + "\": " + std::to_string(count));
        }
        std::printf("# {%s}\n", text.c_str());
    }

private:
    struct Row {
        std::int64_t stamp_ns;
        std::vector<double> pose;
        double age_ms;  ///< of the stamp on arrival
    };

    template <class Hear>
    void listen(FastDds& node, const std::string& topic, const std::string& type, Hear hear) {
        listeners_.push_back(std::make_unique<WireListener>([this, hear, topic](Bytes& bytes) {
            const std::lock_guard lock(mutex_);
            try {
                from_wire(bytes, hear);
                ++counts_[topic];
            } catch (const std::exception& e) {
                std::fprintf(stderr, "%s: %s\n", topic.c_str(), e.what());
                ++counts_["unreadable"];
            }
        }));
        node.reader(topic, type, listeners_.back().get());
    }
    void require(bool is_true) { counts_["wrong"] += is_true ? 0 : 1; }
    std::int64_t hear_header(Cdr& cdr) {
        std::string frame;
        const std::int64_t stamp_ns = read_header(cdr, frame);
        require(frame == "odom");
        return stamp_ns;
    }

    void hear_odometry(Cdr& cdr) {
        const std::int64_t stamp_ns = hear_header(cdr);
        std::string child;
        cdr >> child;
        const std::vector<double> pose = read_doubles(cdr, 7);
        const std::vector<double> pose_covariance = read_doubles(cdr, 36);
        const std::vector<double> twist = read_doubles(cdr, 6);
        const std::vector<double> twist_covariance = read_doubles(cdr, 36);
        require(child == "base_link");
        for (std::size_t i = 0; i < 36; i += 7) {
            require(pose_covariance[i] > 0.0 && twist_covariance[i] > 0.0);
        }
        rows_.push_back({stamp_ns, pose, static_cast<double>(now_ns() - stamp_ns) * 1e-6});
    }
    void hear_transform(Cdr& cdr) {
        std::uint32_t count = 0;
        cdr >> count;
        require(count == 1);
        const std::int64_t stamp_ns = hear_header(cdr);
        std::string child;
        cdr >> child;
        const std::vector<double> pose = read_doubles(cdr, 7);
        require(child == "base_link" && std::abs(now_ns() - stamp_ns) < 10 * kSecond_ns && std::isfinite(pose[0]));
    }
    void hear_diagnostics(Cdr& cdr) {
        std::string frame, name, message, hardware;
        (void)read_header(cdr, frame);
        std::uint32_t count = 0;
        std::uint32_t values = 0;
        std::uint8_t level = 9;
        cdr >> count >> level >> name >> message >> hardware >> values;
        bool is_tracking = false;
        for (std::uint32_t i = 0; i < values; ++i) {
            std::string key, value;
            cdr >> key >> value;
            is_tracking = is_tracking || (key == "state" && value == "TRACKING");
        }
        require(count == 1 && level <= 3 && name == "facet: estimator" && values == 6);
        counts_["tracking"] += is_tracking && level == 0 ? 1 : 0;
    }
    void hear_marker(Cdr& cdr, const std::string& expected) {
        (void)hear_header(cdr);
        std::string ns;
        std::int32_t id = 0, type = 0, action = 0;
        cdr >> ns >> id >> type >> action;
        (void)read_doubles(cdr, 7 + 3);
        float colour = 0.0F;
        for (int i = 0; i < 4; ++i) {
            cdr >> colour;
        }
        std::int32_t sec = 0;
        std::uint32_t number = 0;
        bool flag = false;
        std::string text;
        std::vector<std::uint8_t> bytes;
        cdr >> sec >> number >> flag;
        std::uint32_t points = 0;
        cdr >> points;
        for (const double x : read_doubles(cdr, std::size_t{3} * points)) {
            require(std::abs(x) < 100.0);
        }
        std::uint32_t colours = 0;
        cdr >> colours;
        for (std::uint32_t i = 0; i < 4 * colours; ++i) {
            cdr >> colour;
            require(colour >= 0.0F && colour <= 1.0F);
        }
        cdr >> text >> sec >> number >> text >> text >> bytes;  // texture
        std::uint32_t coordinates = 0;
        cdr >> coordinates >> text >> text >> text >> bytes >> flag;
        require(ns == expected && type == 11 && colours == points && points % 3 == 0 && (action == 0) == (points > 0));
        counts_[expected + "_triangles"] = points / 3;
    }
    void hear_cloud(Cdr& cdr) {
        (void)hear_header(cdr);
        std::uint32_t height = 0, width = 0, fields = 0;
        cdr >> height >> width >> fields;
        for (std::uint32_t i = 0; i < fields; ++i) {
            std::string name;
            std::uint32_t offset = 0, count = 0;
            std::uint8_t type = 0;
            cdr >> name >> offset >> type >> count;
            require(name == std::string(1, static_cast<char>('x' + i)) && offset == 4 * i && type == 7 && count == 1);
        }
        bool is_big = true, is_dense = false;
        std::uint32_t point_step = 0, row_step = 0;
        std::vector<std::uint8_t> data;
        cdr >> is_big >> point_step >> row_step >> data >> is_dense;
        require(fields == 3 && height == 1 && !is_big && is_dense && point_step == 12 && data.size() == 12U * width);
        counts_["landmarks"] = width;
    }
    void hear_path(Cdr& cdr) {
        (void)hear_header(cdr);
        std::uint32_t poses = 0;
        cdr >> poses;
        for (std::uint32_t i = 0; i < poses; ++i) {
            (void)hear_header(cdr);
            (void)read_doubles(cdr, 7);
        }
        counts_["path_poses"] = poses;
    }
    void hear_grid(Cdr& cdr) {
        const std::int64_t stamp_ns = hear_header(cdr);
        std::int32_t sec = 0;
        std::uint32_t nanosec = 0, width = 0, height = 0;
        float cell_m = 0.0F;
        std::vector<std::int8_t> cells;
        cdr >> sec >> nanosec >> cell_m >> width >> height;
        const std::vector<double> origin = read_doubles(cdr, 7);
        cdr >> cells;
        const auto count = [&](std::int8_t value) { return std::count(cells.begin(), cells.end(), value); };
        const auto all = static_cast<std::int64_t>(cells.size());
        require(sec * kSecond_ns + nanosec == stamp_ns && cell_m > 0.0F && all == std::int64_t{width} * height);
        require(origin[3] == 0.0 && origin[6] == 1.0 && count(0) + count(100) + count(-1) == all);
        // It rolls with the vehicle, which began at the origin.
        require(std::abs(origin[0] + 0.5 * width * cell_m) < 5.0 && std::abs(origin[1] + 0.5 * height * cell_m) < 5.0);
        counts_["grid_free"] = count(0);
        counts_["grid_occupied"] = count(100);
    }

    std::mutex mutex_;
    std::vector<std::unique_ptr<WireListener>> listeners_;
    std::vector<Row> rows_;
    std::map<std::string, std::int64_t> counts_{{"unreadable", 0}, {"wrong", 0}};
};

bool await_subscribers(const std::vector<dds::DataWriter*>& writers) {
    constexpr int kTries = 2000;
    for (int i = 0; i < kTries; ++i) {
        bool all = true;
        for (dds::DataWriter* writer : writers) {
            dds::PublicationMatchedStatus matched;
            (void)writer->get_publication_matched_status(matched);
            all = all && matched.current_count > 0;
        }
        if (all) {
            return true;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

enum Topic : std::uint8_t { kLeft, kRight, kImu, kLeftInfo, kTopics };

struct Message {
    Topic topic;
    Bytes bytes;
};

/// What is published at an instant.
struct Event {
    std::int64_t log_ns;
    std::vector<Message> messages;
};

/// The stamp is the first thing behind the encapsulation of a message that begins with a header.
void set_stamp(Bytes& bytes, std::int64_t stamp_ns) {
    const auto sec = static_cast<std::int32_t>(stamp_ns / kSecond_ns);
    const auto nanosec = static_cast<std::uint32_t>(stamp_ns % kSecond_ns);
    std::memcpy(bytes.data() + 4, &sec, sizeof sec);
    std::memcpy(bytes.data() + 8, &nanosec, sizeof nanosec);
}

/// All messages of a log, before the first one is published: decoding images takes its time.
std::vector<Event> events_of(const std::string& dataset) {
    AslDataset log;
    std::string error;
    AslOptions options;
    options.imu_tail = Duration::from_seconds(0.1);
    if (!ok(log.open(dataset, options, {}, error))) {
        throw std::runtime_error(error);
    }
    std::vector<Event> events;
    ImuSample sample;
    StereoFrame frame;
    for (;;) {
        switch (log.next(sample, frame)) {
            case AslDataset::Event::kEnd: return events;
            case AslDataset::Event::kImu: events.push_back({sample.stamp.ns, {{kImu, imu_message(0, sample)}}}); break;
            case AslDataset::Event::kFrame:
                events.push_back({frame.stamp.ns,
                                  {{kLeft, image_message(0, frame.left, false)},
                                   {kRight, image_message(0, frame.right, true)},
                                   {kLeftInfo, info_message(0, frame.left)}}});
                break;
        }
    }
}

int fly(const std::string& dataset, int domain) {
    const std::vector<Event> events = events_of(dataset);
    FastDds node(domain);
    const char* const image = "sensor_msgs::msg::dds_::Image_";
    const char* const info = "sensor_msgs::msg::dds_::CameraInfo_";
    const std::vector<dds::DataWriter*> writers{
        node.writer("/left/image_raw", image, true), node.writer("/right/image_raw", image, false),
        node.writer("/imu/data", "sensor_msgs::msg::dds_::Imu_", true), node.writer("/left/camera_info", info, true)};
    Listener listener(node);
    if (!await_subscribers(writers)) {
        std::fprintf(stderr, "nobody subscribes\n");
        return 1;
    }
    std::int64_t shift_ns = 0;  // from the log's time to this computer's
    for (const Event& event : events) {
        if (shift_ns == 0) {
            shift_ns = now_ns() + kSecond_ns / 2 - event.log_ns;
        }
        const std::int64_t stamp_ns = event.log_ns + shift_ns;
        std::this_thread::sleep_until(Clock::time_point(std::chrono::nanoseconds(stamp_ns)));
        for (Message message : event.messages) {
            set_stamp(message.bytes, stamp_ns);
            writers[message.topic]->write(&message.bytes);
        }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    listener.print(-shift_ns);
    return 0;
}

}  // namespace
}  // namespace facet::test

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: fast_dds_peer DATASET DOMAIN\n");
        return 2;
    }
    try {
        return facet::test::fly(argv[1], std::atoi(argv[2]));
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 1;
    }
}
