// SPDX-License-Identifier: BSD-2-Clause
// Bags as people bring them: sensors split over topics, compressed, deep images, several cameras, other clocks.
#include <sqlite3.h>
#include <zstd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>

#include "app/calibration/calibration.h"
#include "app/lab/convert/import_bag.h"
#include "app/lab/convert/split_imu.h"
#include "app/mcap/compressed_file.h"
#include "drivers/replay_asl/csv_file.h"
#include "drivers/replay_asl/image_decoder.h"
#include "tests/app/lab/convert/cdr_bag.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::field_bags_test {

using test::RecordedMessage;
namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kBegin = 1'600'000'000'000'000'000;
constexpr std::uint32_t kWidth = 16;
constexpr std::uint32_t kHeight = 8;
const std::atomic<bool> kGoOn{false};

using Messages = std::vector<RecordedMessage>;

/// Grey value of pixel i of image k: from dark to nearly white.
unsigned grey_at(int k, std::size_t i) { return static_cast<unsigned>((7 * k + 2 * static_cast<int>(i)) % 250); }

/// Five images of 16x8 a camera at 20 Hz. @param pixel  appends a pixel of that grey
void add_images(Messages& messages, const std::string& topic, const std::string& encoding,
                const std::function<void(std::string&, unsigned)>& pixel, std::uint32_t width = kWidth) {
    for (int k = 1; k <= 5; ++k) {
        std::string pixels;
        for (std::size_t i = 0; i < std::size_t{width} * kHeight; ++i) {
            pixel(pixels, grey_at(k, i));
        }
        const std::int64_t stamp = kBegin + k * 50'000'000;
        messages.push_back({stamp + 3'000'000, topic, "sensor_msgs/msg/Image",
                            test::cdr_image(stamp, "camera" + topic, width, kHeight, encoding, pixels)});
    }
}
void add_grey_images(Messages& messages, const std::string& topic) {
    add_images(messages, topic, "mono8", [](std::string& to, unsigned grey) { to += static_cast<char>(grey); });
}
/// Sixty samples at 200 Hz.
void add_imu(Messages& messages, std::int64_t shift_ns = 0, std::int64_t recorded_shift_ns = 0) {
    for (int i = 0; i < 60; ++i) {
        const std::int64_t stamp = kBegin + i * 5'000'000 + shift_ns;
        messages.push_back({stamp + recorded_shift_ns + 1'000'000, "/imu", "sensor_msgs/msg/Imu",
                            test::cdr_imu(stamp, "imu", {0.01, 0.02, 0.03}, {0.0, 0.1, 9.8})});
    }
}
Messages stereo() {
    Messages messages;
    add_grey_images(messages, "/left");
    add_grey_images(messages, "/right");
    add_imu(messages);
    return messages;
}

struct Imported {
    ImportAccount account;
    std::vector<std::string> warnings;
};
ImportOptions options_for(const std::string& bag, const std::string& folder, std::vector<std::string>& warnings) {
    ImportOptions options;
    options.bag = bag;
    options.folder = folder;
    options.progress = [](double) {};
    options.warn = [&](const std::string& line) { warnings.push_back(line); };
    return options;
}
Imported import(
    const std::string& bag, const std::string& folder,
    const std::function<void(ImportOptions&)>& change = [](ImportOptions&) {}) {
    Imported imported;
    ImportOptions options = options_for(bag, folder, imported.warnings);
    change(options);
    imported.account = import_bag(options, kGoOn);
    return imported;
}
std::string complaint(
    const std::string& bag, const std::string& folder,
    const std::function<void(ImportOptions&)>& change = [](ImportOptions&) {}) {
    return test::input_error_text([&] { import(bag, folder, change); });
}

std::vector<std::uint8_t> pixels_of(const std::string& path) {
    ImageDecoder decoder;
    GreyImage image;
    REQUIRE(ok(decoder.decode(path, 0, 0, image)));
    return image.pixels;
}
std::string image_path(const std::string& folder, int camera, int k) {
    return folder + "/mav0/cam" + std::to_string(camera) + "/data/" + std::to_string(kBegin + k * 50'000'000) + ".png";
}
void check_grey_images(const std::string& folder, int tolerance = 0) {
    for (const int camera : {0, 1}) {
        const std::vector<std::uint8_t> pixels = pixels_of(image_path(folder, camera, 2));
        REQUIRE(pixels.size() == kWidth * kHeight);
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            CHECK(std::abs(static_cast<int>(pixels[i]) - static_cast<int>(grey_at(2, i))) <= tolerance);
        }
    }
}
std::vector<std::vector<double>> rows_of(const std::string& path) {
    CsvFile csv;
    REQUIRE(csv.open(path));
    std::vector<std::vector<double>> rows;
    std::vector<std::string_view> fields;
    while (csv.next(fields)) {
        std::vector<double>& row = rows.emplace_back();
        for (const std::string_view field : fields) {
            double value = 0.0;
            REQUIRE(parse_double(field, value));
            row.push_back(value);
        }
    }
    return rows;
}

std::string zstd_of(const std::string& bytes) {
    std::string out(ZSTD_compressBound(bytes.size()), '\0');
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1));
    return out;
}

/// The tables of rosbag2's sqlite3 storage.
void write_sqlite(const std::string& path, const Messages& messages) {
    sqlite3* database = nullptr;
    REQUIRE(sqlite3_open(path.c_str(), &database) == SQLITE_OK);
    const auto execute = [&](const std::string& query) {
        REQUIRE(sqlite3_exec(database, query.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
    };
    execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)");
    execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)");
    std::map<std::string, int> ids;
    for (const RecordedMessage& m : messages) {
        if (!ids.contains(m.topic)) {
            ids[m.topic] = static_cast<int>(ids.size()) + 1;
            execute("INSERT INTO topics VALUES(" + std::to_string(ids[m.topic]) + ",'" + m.topic + "','" + m.type +
                    "','cdr')");
        }
        sqlite3_stmt* row = nullptr;
        const std::string query = "INSERT INTO messages(topic_id, timestamp, data) VALUES(" +
                                  std::to_string(ids[m.topic]) + "," + std::to_string(m.time_ns) + ", ?)";
        REQUIRE(sqlite3_prepare_v2(database, query.c_str(), -1, &row, nullptr) == SQLITE_OK);
        sqlite3_bind_blob(row, 1, m.data.data(), static_cast<int>(m.data.size()), SQLITE_TRANSIENT);
        REQUIRE(sqlite3_step(row) == SQLITE_DONE);
        sqlite3_finalize(row);
    }
    sqlite3_close(database);
}

}  // namespace

TEST_CASE("a gyroscope and an accelerometer with a topic each become one IMU at the gyroscope's stamps") {
    const test::TempDir dir;
    Messages messages;
    add_grey_images(messages, "/left");
    add_grey_images(messages, "/right");
    for (int i = 0; i < 60; ++i) {
        const std::int64_t stamp = kBegin + i * 5'000'000;
        messages.push_back({stamp, "/camera/gyro/sample", "sensor_msgs/msg/Imu",
                            test::cdr_imu(stamp, "gyro", {0.01 * i, 0.02, 0.03}, {0, 0, 0})});
        if (i % 3 == 0) {
            const std::int64_t late = stamp + 1'300'000;
            messages.push_back(
                {late, "/camera/accel/sample", "sensor_msgs/msg/Imu",
                 test::cdr_imu(late, "accel", {0, 0, 0}, {1e-9 * static_cast<double>(late - kBegin), 0, 9.8})});
        }
    }
    const std::string bag = dir.file("d435i.mcap");
    test::write_mcap_bag(bag, messages);
    const auto check = [&](const Imported& imported, const std::string& folder) {
        CHECK(imported.account.topics[2] == "/camera/gyro/sample");
        CHECK(imported.account.accelerometer == "/camera/accel/sample");
        const auto rows = rows_of(folder + "/mav0/imu0/data.csv");
        REQUIRE(rows.size() == 57);  // one before the accelerometer's first reading, two behind its last
        CHECK(imported.account.rows[2] == 57);
        CHECK(imported.account.left_out[2] == 3);
        for (const std::vector<double>& row : rows) {
            const double s = 1e-9 * (row[0] - static_cast<double>(kBegin));
            CHECK(row[1] == Approx(2.0 * s).margin(1e-6));
            CHECK(row[4] == Approx(s).margin(1e-6));  // the force grows with time
            CHECK(row[6] == 9.8);
        }
    };
    check(import(bag, dir.file("found")), dir.file("found"));
    // The gyroscope alone, as others advise, or both by name.
    check(import(bag, dir.file("half"), [](ImportOptions& o) { o.topics[2] = "/camera/gyro/sample"; }),
          dir.file("half"));
    check(import(bag, dir.file("other"), [](ImportOptions& o) { o.topics[2] = "/camera/accel/sample"; }),
          dir.file("other"));
    check(import(bag, dir.file("named"),
                 [](ImportOptions& o) { o.topics[2] = "/camera/gyro/sample,/camera/accel/sample"; }),
          dir.file("named"));
    CHECK(complaint(bag, dir.file("no"), [](ImportOptions& o) {
              o.topics[2] = "/camera/gyro/sample,/none";
          }).find("there is no topic /none for imu0") != std::string::npos);
    std::erase_if(messages, [](const RecordedMessage& m) { return m.topic == "/camera/accel/sample"; });
    test::write_mcap_bag(bag, messages);
    CHECK(complaint(bag, dir.file("no")).find("/camera/gyro/sample has angular rates alone") != std::string::npos);
}

TEST_CASE("forces are interpolated, and none is made up in a gap") {
    SplitImu imu;
    for (const std::int64_t stamp : {30, 10, 20, 20, 500'000'000}) {
        imu.add_rates({stamp, {1.0, 2.0, 3.0}});
    }
    for (const std::int64_t stamp : {26, 16, 400'000'000, 600'000'000}) {
        imu.add_forces({stamp, {static_cast<double>(stamp), 0.0, 0.0}});
    }
    std::vector<double> forces;
    std::vector<std::int64_t> stamps;
    CHECK(imu.finish([&](std::int64_t stamp, const std::array<double, 6>& v) {
        stamps.push_back(stamp);
        forces.push_back(v[3]);
    }) == 4);
    CHECK(stamps == std::vector<std::int64_t>{20});  // 10 before the first, 20 twice, 30 and the last in gaps
    CHECK(forces == std::vector<double>{20.0});
}

TEST_CASE("bags that are compressed message by message, or as whole files") {
    const test::TempDir dir;
    Messages messages = stereo();
    // As a whole: the folder of a recorder, the file itself, and a folder without metadata.yaml.
    fs::create_directories(dir.file("file_mode"));
    const std::string database = dir.file("plain.db3");
    write_sqlite(database, messages);
    dir.write("file_mode/bag_0.db3.zstd", zstd_of(test::read_file(database)));
    dir.write("file_mode/metadata.yaml",
              "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - bag_0.db3.zstd\n"
              "  compression_format: zstd\n  compression_mode: FILE\n");
    import(dir.file("file_mode"), dir.file("a"));
    check_grey_images(dir.file("a"));
    import(dir.file("file_mode/bag_0.db3.zstd"), dir.file("b"));
    check_grey_images(dir.file("b"));
    fs::remove(dir.file("file_mode/metadata.yaml"));
    import(dir.file("file_mode"), dir.file("c"));
    check_grey_images(dir.file("c"));
    dir.write("cut.db3.zstd", zstd_of(test::read_file(database)).substr(0, 200));
    CHECK(complaint(dir.file("cut.db3.zstd"), dir.file("no")).find("ends too early") != std::string::npos);
    // More than is allowed, and a reader that is to stop.
    const std::string whole = dir.file("file_mode/bag_0.db3.zstd");
    CHECK(decompress_file(whole, dir.file("part"), 4096).find("more than a recording does") != std::string::npos);
    const std::atomic<bool> stop = true;
    CHECK(decompress_file(whole, dir.file("none"), UINT64_MAX, &stop).empty());
    CHECK(fs::file_size(dir.file("none")) == 0);

    for (RecordedMessage& m : messages) {
        m.data = zstd_of(m.data);
    }
    write_sqlite(dir.file("messages.db3"), messages);
    const Imported imported = import(dir.file("messages.db3"), dir.file("d"));
    CHECK(imported.account.rows == std::array<std::uint64_t, 4>{5, 5, 60, 0});
    check_grey_images(dir.file("d"));
    messages[0].data.resize(messages[0].data.size() - 9);
    test::write_mcap_bag(dir.file("damaged.mcap"), messages);
    const Imported damaged = import(dir.file("damaged.mcap"), dir.file("e"));
    CHECK(damaged.account.left_out[0] == 1);
    REQUIRE_FALSE(damaged.warnings.empty());
    CHECK(damaged.warnings[0] == "a message of /left is compressed and damaged");
}

TEST_CASE("images of 10 and 12 bits in 16 keep their light, by the brightest pixel or as given") {
    const test::TempDir dir;
    for (const unsigned bits : {10U, 12U, 16U}) {
        CAPTURE(bits);
        Messages messages;
        for (const char* topic : {"/left", "/right"}) {
            add_images(messages, topic, "mono16", [&](std::string& to, unsigned grey) {
                const unsigned value = (grey * ((1U << bits) - 1U) + 127U) / 255U;
                to += static_cast<char>(value & 0xFFU);
                to += static_cast<char>(value >> 8U);
            });
        }
        add_imu(messages);
        const std::string bag = dir.file(std::to_string(bits) + ".mcap");
        test::write_mcap_bag(bag, messages);
        const std::string folder = dir.file("log" + std::to_string(bits));
        CHECK(import(bag, folder).account.bits == static_cast<int>(bits));
        check_grey_images(folder, 1);
        import(bag, folder + "_told", [](ImportOptions& o) { o.bits = 16;
    });
    CHECK((pixels_of(image_path(folder + "_told", 0, 2))[100] <= 16) == (bits < 16));
}
}  // namespace facet::field_bags_test

TEST_CASE("two images side by side in one become two") {
    const test::TempDir dir;
    Messages messages;
    std::size_t i = 0;
    add_images(
        messages, "/stereo", "yuv422_yuy2",
        [&](std::string& to, unsigned) {
            to += static_cast<char>(i++ / kWidth % 2 == 0 ? 50 : 200);
            to += static_cast<char>(128);
        },
        2 * kWidth);
    add_imu(messages);
    const std::string bag = dir.file("stereo.mcap");
    test::write_mcap_bag(bag, messages);
    const Imported imported = import(bag, dir.file("log"), [](ImportOptions& o) { o.is_side_by_side = true; });
    CHECK(imported.account.rows == std::array<std::uint64_t, 4>{5, 5, 60, 0});
    for (const int camera : {0, 1}) {
        CHECK(pixels_of(image_path(dir.file("log"), camera, 3)) ==
              std::vector<std::uint8_t>(kWidth * kHeight, camera == 0 ? 50 : 200));
    }
}

TEST_CASE("of several cameras the pair that is called left and right is taken, or a command is proposed") {
    const test::TempDir dir;
    Messages messages;
    for (const char* topic : {"/camera/infra1/image_rect_raw", "/camera/infra2/image_rect_raw",
                              "/camera/color/image_raw", "/camera/depth/image_rect_raw"}) {
        add_grey_images(messages, topic);
    }
    add_imu(messages);
    const std::string bag = dir.file("d455.mcap");
    test::write_mcap_bag(bag, messages);
    const Imported imported = import(bag, dir.file("log"));
    CHECK(imported.account.topics[0] == "/camera/infra1/image_rect_raw");
    CHECK(imported.account.topics[1] == "/camera/infra2/image_rect_raw");
    REQUIRE(imported.warnings.size() == 1);
    CHECK(imported.warnings[0].find("of 3 topics of images") == 0);

    Messages mono;
    add_grey_images(mono, "/color/image_raw");
    add_grey_images(mono, "/depth/image_raw");
    add_imu(mono);
    test::write_mcap_bag(bag, mono);
    CHECK(import(bag, dir.file("mono")).account.topics[1].empty());

    Messages odd;
    for (const char* topic : {"/a", "/m", "/z"}) {
        add_grey_images(odd, topic);
    }
    add_imu(odd);
    test::write_mcap_bag(bag, odd);
    std::vector<std::string> warnings;
    const std::string text =
        test::input_error_text([&] { import_bag(options_for(bag, dir.file("no"), warnings), kGoOn); });
    CHECK(text.find("has 3 topics of images; say --left and --right, for example --left /a --right /m") !=
          std::string::npos);
    CHECK(warnings.size() == 4);  // the table of topics
    CHECK(warnings[0].find("topic /a: sensor_msgs/Image, 5 messages at 20.0 Hz, 16x8 mono8") == 0);
}

TEST_CASE("camera_info and tf_static become the log's calibration") {
    const test::TempDir dir;
    Messages messages = stereo();
    const std::vector<double> k{12, 0, 7.5, 0, 12, 3.5, 0, 0, 1};
    const std::vector<double> p{12, 0, 7.5, 0, 0, 12, 3.5, 0, 0, 0, 1, 0};
    for (const char* side : {"left", "right"}) {
        for (RecordedMessage& m : messages) {
            m.topic = m.topic == std::string("/") + side ? std::string("/") + side + "/image_raw" : m.topic;
        }
        messages.push_back({kBegin, std::string("/") + side + "/camera_info", "sensor_msgs/msg/CameraInfo",
                            test::cdr_camera_info(std::string(side) + "_optical", kWidth, kHeight, "plumb_bob",
                                                  {0.01, 0.002, 0.0, 0.0, 0.0}, k, p)});
    }
    // imu -> base -> left, and left -> right: against the tree's direction and along it.
    messages.push_back({kBegin, "/tf_static", "tf2_msgs/msg/TFMessage",
                        test::cdr_transforms({{"base", "/imu", {0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0}},
                                              {"base", "left_optical", {0.1, 0.0, 0.0, -0.5, 0.5, -0.5, 0.5}},
                                              {"left_optical", "right_optical", {0.06, 0, 0, 0, 0, 0, 1}}})});
    const std::string bag = dir.file("bag.mcap");
    test::write_mcap_bag(bag, messages);
    const Imported imported = import(bag, dir.file("log"));
    CHECK(imported.account.is_own_calibration);
    const Calibration c = load_calibration(dir.file("log/mav0"), "", "");
    CHECK(c.rig.left.intrinsics().fx == 12.0);
    CHECK(c.rig.left.intrinsics().distortion == Distortion::kRadialTangential);
    CHECK(c.rig.left.intrinsics().coeffs[1] == 0.002);
    CHECK((c.rig.T_B_C0.p - Eigen::Vector3d(0.1, 0.0, -0.2)).norm() < 1e-9);
    CHECK((c.rig.T_B_C0.q * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm() < 1e-9);
    CHECK((c.rig.T_C1_C0().p - Eigen::Vector3d(-0.06, 0.0, 0.0)).norm() < 1e-9);
    CHECK(c.noise.rate_hz == Approx(200.0));

    // Without a way from the IMU to the cameras there is none, which is told.
    messages.pop_back();
    test::write_mcap_bag(bag, messages);
    CHECK(import(bag, dir.file("none")).account.calibration_lack ==
          "no way from 'imu' to 'left_optical' in /tf_static");
    CHECK_FALSE(fs::exists(dir.file("none/mav0/cam0/sensor.yaml")));
}

TEST_CASE("clocks that have nothing in common are reported, and aligned on demand") {
    const test::TempDir dir;
    Messages messages;
    add_grey_images(messages, "/left");
    // Stamps count from the boot, 12 s; recorded by a clock of its own, or by that of the images.
    constexpr std::int64_t kBoot = 12'000'000'000 - kBegin;
    const bool has_recorder = GENERATE(true, false);
    add_imu(messages, kBoot, has_recorder ? -kBoot : 0);
    const std::string bag = dir.file("bag.mcap");
    test::write_mcap_bag(bag, messages);
    CHECK(complaint(bag, dir.file("no"))
              .find("images run from 1600000000.050 to 1600000000.250 s and inertial samples "
                    "from 12.000 to 12.295 s: their clocks differ") != std::string::npos);
    CHECK_FALSE(fs::exists(dir.file("no")));
    const Imported imported = import(bag, dir.file("log"), [](ImportOptions& o) { o.align_clocks = true; });
    REQUIRE(imported.warnings.size() == 1);
    CHECK((imported.warnings[0].find("which is a guess") == std::string::npos) == has_recorder);
    const double first = rows_of(dir.file("log/mav0/imu0/data.csv"))[0][0];
    // The recorder saw samples 1 ms and images 3 ms after they were taken.
    const double expected = static_cast<double>(kBegin) + (has_recorder ? -2e6 : 50e6);
    CHECK(std::abs(first - expected) < 1e3);
}

TEST_CASE("PX4: SensorCombined is an IMU, VehicleOdometry the truth with z upwards") {
    const test::TempDir dir;
    Messages messages;
    add_grey_images(messages, "/left");
    for (int i = 0; i < 60; ++i) {
        const std::uint64_t us = static_cast<std::uint64_t>(kBegin / 1000) + static_cast<std::uint64_t>(i) * 5000U;
        const auto stamp = static_cast<std::int64_t>(us) * 1000;
        test::CdrMessage imu;
        imu.put(us).put(0.1F).put(0.2F).put(0.3F).put(std::uint32_t{5000}).put(std::int32_t{0});
        imu.put(0.5F).put(0.25F).put(-9.75F);
        messages.push_back({stamp, "/fmu/out/sensor_combined", "px4_msgs/msg/SensorCombined", imu.bytes()});
        test::CdrMessage odometry;
        odometry.put(us + 100).put(us).put(std::uint8_t{1}).put(1.0F).put(2.0F).put(-3.0F);
        odometry.put(0.5F).put(0.5F).put(-0.5F).put(0.5F);
        messages.push_back({stamp, "/fmu/out/vehicle_odometry", "px4_msgs/msg/VehicleOdometry", odometry.bytes()});
    }
    test::write_mcap_bag(dir.file("px4.mcap"), messages);
    import(dir.file("px4.mcap"), dir.file("log"));
    const auto imu = rows_of(dir.file("log/mav0/imu0/data.csv"));
    REQUIRE(imu.size() == 60);
    CHECK(imu[3][3] == Approx(0.3));
    CHECK(imu[3][6] == -9.75);
    const auto truth = rows_of(dir.file("log/mav0/state_groundtruth_estimate0/data.csv"));
    REQUIRE(truth.size() == 60);
    CHECK(std::vector<double>(truth[0].begin() + 1, truth[0].end()) ==
          std::vector<double>{1.0, -2.0, 3.0, -0.5, 0.5, -0.5, -0.5});
}

}  // namespace facet::field_bags_test
