// SPDX-License-Identifier: BSD-2-Clause
// Images, videos and tables of inertial samples as people bring them become a log.
#include "app/lab/convert/import_files.h"

#include <fmt/format.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <functional>

#include "app/calibration/calibration.h"
#include "app/lab/convert/inertial_table.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "tests/app/lab/convert/test_video.h"
#include "tests/support/asl_folder.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::import_files_test {

using test::input_error_text;
namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kFirst = 1'600'000'000'000'000'000;
constexpr std::int64_t kFrameStep = 50'000'000;
const std::atomic<bool> kRunOn{false};

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

int grey_at(int camera, int k) { return 20 + 10 * k + 100 * camera; }

/// Six frames of 16x8, each of one grey value.
std::string frame_png(int camera, int k) {
    return test::encode_png(16, 8, 1, 8,
                            std::vector<std::uint16_t>(16 * 8, static_cast<std::uint16_t>(grey_at(camera, k))));
}
void write_frames(const test::TempDir& dir, const std::string& folder, int camera,
                  const std::function<std::string(int)>& name) {
    for (int k = 0; k < 6; ++k) {
        dir.write(folder + "/" + name(k), frame_png(camera, k));
    }
}

/// 80 samples at 200 Hz: rates 0.1, 0.2, 0.3, forces 1, 2, 9.5. @param row  of a stamp in ns
std::string imu_rows(const std::function<std::string(std::int64_t)>& row, const std::string& header = "") {
    std::string text = header;
    for (int i = 0; i < 80; ++i) {
        text += row(kFirst - 20'000'000 + i * 5'000'000) + "\n";
    }
    return text;
}
std::string plain_imu() {
    return imu_rows([](std::int64_t ns) { return fmt::format("{},0.1,0.2,0.3,1,2,9.5", ns); });
}

struct Imported {
    FilesAccount account;
    std::vector<std::string> warnings;
    std::vector<std::int64_t> stamps;  ///< of frames
    std::vector<std::array<int, 2>> greys;
    std::vector<ImuSample> samples;
};

/// Imports, and reads the log with the reader of logs.
Imported import(const test::TempDir& dir, FilesOptions options) {
    Imported result;
    fs::remove_all(dir.file("log"));
    options.folder = dir.file("log");
    options.progress = [](double share) { REQUIRE(share <= 1.0); };
    options.warn = [&](const std::string& line) { result.warnings.push_back(line); };
    if (options.imu.empty()) {
        options.imu = dir.write("imu.csv", plain_imu());
    }
    result.account = import_files(options, kRunOn);
    AslDataset log;
    std::string error;
    REQUIRE(ok(log.open(
        dir.file("log"), {}, [&](const AslWarning& w) { result.warnings.push_back(w.text()); }, error)));
    ImuSample sample;
    StereoFrame frame;
    for (auto event = log.next(sample, frame); event != AslDataset::Event::kEnd; event = log.next(sample, frame)) {
        if (event == AslDataset::Event::kImu) {
            result.samples.push_back(sample);
            continue;
        }
        result.stamps.push_back(frame.stamp.ns);
        const auto grey = [](const ImageView& view) { return view.data == nullptr ? -1 : int{view.row(3)[5]}; };
        result.greys.push_back({grey(frame.left), grey(frame.right)});
    }
    return result;
}

void check_frames(const Imported& result, bool has_right, int tolerance = 0) {
    CHECK(result.warnings.empty());
    REQUIRE(result.stamps.size() == 6);
    for (int k = 0; k < 6; ++k) {
        const auto i = static_cast<std::size_t>(k);
        CHECK(result.stamps[i] == kFirst + k * kFrameStep);
        CHECK(std::abs(result.greys[i][0] - grey_at(0, k)) <= tolerance);
        CHECK((has_right ? std::abs(result.greys[i][1] - grey_at(1, k)) <= tolerance : result.greys[i][1] == -1));
    }
}

FilesOptions sources(const std::string& left, const std::string& right = "") {
    FilesOptions options;
    options.images = {left, right};
    return options;
}

}  // namespace

TEST_CASE("a list of files with stamps: columns, units and separators as they come") {
    const test::TempDir dir;
    const auto name = [](int k) { return fmt::format("frame {}.png", k); };
    write_frames(dir, "left", 0, name);
    write_frames(dir, "right", 1, name);
    struct Form {
        const char* header;
        std::function<std::string(std::int64_t ns, const std::string& file, int k)> row;
    };
    const auto s = [](std::int64_t ns) { return fmt::format("{}.{:09}", ns / 1'000'000'000, ns % 1'000'000'000); };
    const Form forms[] = {
        {"# color images\n# file: 'desk.bag'\n# timestamp filename\n",
         [&](auto ns, auto& file, int) { return s(ns) + "\t" + file; }},
        {"#timestamp [ns],filename\r\n", [](auto ns, auto& file, int) { return fmt::format("{},{}\r", ns, file); }},
        {"\xEF\xBB\xBFname;exposure;timestamp\n",
         [](auto ns, auto& file, int) { return fmt::format("{};0.004;{}", file, ns / 1000); }},
        {"id,file,time_ms\n",
         [](auto ns, auto& file, int k) { return fmt::format("{},\"{}\",{}", k, file, ns / 1'000'000); }},
        {"", [](auto ns, auto& file, int k) { return fmt::format("{}, {}, {}", k, ns, file); }},
    };
    for (const Form& form : forms) {
        CAPTURE(form.header);
        std::array<std::string, 2> paths;
        for (const char* side : {"left", "right"}) {
            std::string text = form.header;
            for (int k = 0; k < 6; ++k) {
                text += form.row(kFirst + k * kFrameStep, std::string(side) + "/" + name(k), k) + "\n";
            }
            paths[side[0] == 'r' ? 1 : 0] = dir.write(std::string(side) + ".txt", text);
        }
        check_frames(import(dir, sources(paths[0], paths[1])), true);
        check_frames(import(dir, sources(paths[0])), false);
    }
}

TEST_CASE("a list of both cameras, of names that are stamps, and one out of order") {
    const test::TempDir dir;
    const auto stamp_name = [](int k) { return fmt::format("{}.png", kFirst + k * kFrameStep); };
    write_frames(dir, "data", 0, stamp_name);
    write_frames(dir, "other", 1, stamp_name);
    std::string both = "timestamp,cam1,depth,cam0\n";
    std::string names;
    for (const int k : {1, 0, 2, 3, 5, 4}) {
        both += fmt::format("{0},other/{1},depth/{1},data\\{1}\n", kFirst + k * kFrameStep, stamp_name(k));
        names += stamp_name(k) + "\n";  // below data/
    }
    check_frames(import(dir, sources(dir.write("both.csv", both))), true);
    check_frames(import(dir, sources(dir.write("names.txt", names))), false);
    check_frames(import(dir, sources(dir.file("data"), dir.file("other"))), true);
}

TEST_CASE("folders with a table of stamps, images side by side, other formats") {
    const test::TempDir dir;
    std::string stamps = "#timestamp\n";
    for (int k = 0; k < 6; ++k) {
        stamps += fmt::format("{}\n", kFirst + k * kFrameStep);
        dir.write(fmt::format("one/{}.pgm", k + 7),
                  "P5\n16 8\n255\n" + std::string(128, static_cast<char>(grey_at(0, k))));
        std::string row =
            std::string(16, static_cast<char>(grey_at(0, k))) + std::string(16, static_cast<char>(grey_at(1, k)));
        std::string pixels;
        for (int v = 0; v < 8; ++v) {
            pixels += row;
        }
        dir.write(fmt::format("two/img_{:02}.pgm", k), "P5\n32 8\n255\n" + pixels);
    }
    FilesOptions one = sources(dir.file("one"));
    one.stamps[0] = dir.write("stamps.txt", stamps);
    check_frames(import(dir, one), false);
    CHECK(fs::exists(dir.file(fmt::format("log/mav0/cam0/data/{}.pgm", kFirst))));
    FilesOptions two = sources(dir.file("two"));
    two.stamps[0] = dir.file("stamps.txt");
    two.is_side_by_side = true;
    check_frames(import(dir, two), true);
    const auto complaint = [&](FilesOptions options) { return input_error_text([&] { import(dir, options); }); };
    CHECK(says(complaint(sources(dir.file("two"))), "the names of its images are not stamps: --stamps FILE"));
    two.stamps[0] = dir.write("few.txt", "1\n2\n3\n");
    CHECK(says(complaint(two), "has 3 stamps, but " + dir.file("two") + " has 6 images"));
}

TEST_CASE("what is missing in a list is left out and reported, and a log without a source is refused in a sentence") {
    const test::TempDir dir;
    write_frames(dir, "left", 0, [](int k) { return fmt::format("{}.png", k); });
    fs::remove(dir.file("left/2.png"));
    dir.write("left/3.png", "no image");
    std::string text;
    for (int k = 0; k < 6; ++k) {
        text += fmt::format("{} left/{}.png\n", kFirst + k * kFrameStep, k);
    }
    const Imported result = import(dir, sources(dir.write("rgb.txt", text)));
    CHECK(result.account.images[0] == 4);
    CHECK(result.account.left_out[0] == 2);
    REQUIRE(result.warnings.size() == 1);
    CHECK(says(result.warnings[0], "left/2.png: is not there; left out, as others of its kind will be"));
    const auto complaint = [&](const std::string& list, const std::string& imu = "") {
        FilesOptions options = sources(dir.write("list.txt", list));
        options.imu = imu;
        return input_error_text([&] { import(dir, options); });
    };
    CHECK(says(complaint("1 2 3\n4 5 6\n"), "list.txt:2: has no column with names of image files"));
    CHECK(says(complaint("a.png b\nc.png d\n"), "has no column with stamps, and the names of the files are none"));
    CHECK(says(complaint("1.0 a.png\n1.0001 b.png\n"), "stamps whose median step is 0.0001 fit neither"));
    CHECK(says(complaint("1.0 a.png\n1.1\n"), "the row '1.1' lacks a stamp or a name"));
    CHECK(says(complaint(text, dir.write("late.csv", imu_rows([](std::int64_t ns) {
                                             return fmt::format("{},0,0,0,0,0,9.8", ns + 100'000'000'000);
                                         }))),
               "images run from 1600000000.000 to 1600000000.250 s and inertial samples from 1600000099.980"));
    FilesOptions none = sources(dir.file("list.txt"));
    none.folder = dir.file("x");
    CHECK(says(input_error_text([&] { import_files(none, kRunOn); }), "images without inertial samples: --imu FILE"));
}

TEST_CASE("inertial tables: columns by name in any order, units in the names, two files") {
    const test::TempDir dir;
    std::vector<std::string> warnings;
    const auto read = [&](const std::string& paths) {
        warnings.clear();
        return read_inertial_table(paths, [&](const std::string& line) { warnings.push_back(line); });
    };
    const auto check = [&](const InertialTable& table, std::size_t count = 80) {
        REQUIRE(table.samples.size() == count);
        const std::array<double, 6> expected{0.1, 0.2, 0.3, 1.0, 2.0, 9.5};
        for (std::size_t i = 0; i < 6; ++i) {
            CHECK(table.samples[40].values[i] == Approx(expected[i]).epsilon(1e-6));
        }
        CHECK(table.samples[40].stamp_ns == kFirst + 180'000'000);
    };
    struct Form {
        const char* header;
        const char* row;  ///< {0} is the stamp in ns, {1} in s, {2} in us
    };
    const Form forms[] = {
        {"#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m "
         "s^-2],a_RS_S_z [m s^-2]\n",
         "{0},0.1,0.2,0.3,1,2,9.5"},
        {"timestamp,ax,ay,az,gx,gy,gz,temperature\n", "{2},1,2,9.5,0.1,0.2,0.3,25"},
        {"acc_x (g);acc_y (g);acc_z (g);gyro_x (deg/s);gyro_y (deg/s);gyro_z (deg/s);time (s)\n",
         "0.101971621;0.203943243;0.968730404;5.729577951;11.459155903;17.188733854;{1}"},
        {"# id timestamp ang_vel_x ang_vel_y ang_vel_z lin_acc_x lin_acc_y lin_acc_z\n", "7 {1} 0.1 0.2 0.3 1 2 9.5"},
        {"%time,field.header.seq,field.header.stamp,field.orientation.x,field.orientation_covariance0,"
         "field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z,"
         "field.angular_velocity_covariance0,field.linear_acceleration.x,field.linear_acceleration.y,"
         "field.linear_acceleration.z,field.linear_acceleration_covariance0\n",
         "1,2,{0},0,0,0.1,0.2,0.3,0,1,2,9.5,0"},
        {"", "{0} 0.1 0.2 0.3 1 2 9.5"},
        {"", "{0},0.1,0.2,0.3,1,2,9.5"},
    };
    for (const Form& form : forms) {
        CAPTURE(form.header);
        const std::string text = imu_rows(
            [&](std::int64_t ns) {
                const std::string s = fmt::format("{}.{:09}", ns / 1'000'000'000, ns % 1'000'000'000);
                return fmt::format(fmt::runtime(form.row), ns, s, ns / 1000);
            },
            form.header);
        check(read(dir.write("imu.csv", text)));
        CHECK(warnings.empty());
    }
    // A stamp in two columns.
    check(read(dir.write("bagpy.csv", imu_rows(
                                          [](std::int64_t ns) {
                                              return fmt::format("9.5,{},{},0.1,0.2,0.3,1,2,9.5", ns / 1'000'000'000,
                                                                 ns % 1'000'000'000);
                                          },
                                          "Time,header.stamp.secs,header.stamp.nsecs,angular_velocity.x,"
                                          "angular_velocity.y,angular_velocity.z,linear_acceleration.x,"
                                          "linear_acceleration.y,linear_acceleration.z\n"))));
    // Forces first without names: gravity shows it. Multiples of g without a unit are told.
    check(read(
        dir.write("swapped.csv", imu_rows([](std::int64_t ns) { return fmt::format("{},1,2,9.5,0.1,0.2,0.3", ns); }))));
    REQUIRE(warnings.size() == 1);
    CHECK(says(warnings[0], "columns 2 to 4 hold gravity"));
    read(dir.write("g.csv", imu_rows([](std::int64_t ns) { return fmt::format("{},0,0,0,0,0,0.99", ns); })));
    REQUIRE(warnings.size() == 1);
    CHECK(says(warnings[0], "the specific force is 0.99 m/s^2 in the median"));
    // Two files, of which the second is interpolated.
    const std::string gyro = dir.write(
        "gyro.csv", imu_rows([](std::int64_t ns) { return fmt::format("{},0.1,0.2,0.3", ns); }, "timestamp,x,y,z\n"));
    const std::string accel =
        dir.write("accel.csv", imu_rows([](std::int64_t ns) { return fmt::format("{},1,2,9.5", ns + 2'000'000); }));
    const InertialTable split = read(gyro + "," + accel);
    REQUIRE(split.samples.size() == 79);
    CHECK(split.samples[39].stamp_ns == kFirst + 180'000'000);
    CHECK(split.samples[39].values == std::array{0.1, 0.2, 0.3, 1.0, 2.0, 9.5});
    CHECK(split.left_out == 1);
    CHECK(warnings.empty());
    read(gyro + "," + gyro);
    CHECK(says(warnings.at(0), "are these multiples of g"));
    // Damage is left out and counted.
    const InertialTable damaged =
        read(dir.write("damaged.csv", plain_imu() + "5\nx,1,2,3,4,5,6\n" + fmt::format("{},0,nan,0,0,0,0\n", kFirst)));
    check(damaged);
    CHECK(damaged.left_out == 3);
    const auto complaint = [&](const std::string& paths) { return input_error_text([&] { read(paths); }); };
    CHECK(says(complaint(gyro),
               "gyro.csv:2: has 4 columns: needed are stamp, angular rate x y z, specific force x y z, or names"));
    CHECK(says(complaint(accel), "accel.csv:1: has 4 columns: needed are stamp"));
    CHECK(says(complaint(dir.write("empty.csv", "timestamp,wx\n")), "holds no inertial samples"));
    CHECK(says(complaint(dir.file("nowhere.csv")), "nowhere.csv"));
}

TEST_CASE("clocks without time in common are aligned if that is asked for, and a calibration that is given is kept") {
    const test::TempDir dir;
    write_frames(dir, "left", 0, [](int k) { return fmt::format("{}.png", kFirst + k * kFrameStep); });
    FilesOptions options = sources(dir.file("left"));
    options.imu = dir.write("boot.csv", imu_rows([](std::int64_t ns) {
                                return fmt::format("{},0.1,0.2,0.3,1,2,9.5", ns - kFirst + 5'000'000'000);
                            }));
    options.align_clocks = true;
    const std::string lens =
        "resolution: [16, 8], camera_model: pinhole, intrinsics: [12, 12, 7.5, 3.5], distortion_model: radtan, "
        "distortion_coeffs: [0, 0, 0, 0], T_cam_imu: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]";
    options.cameras = dir.write("camchain.yaml", "cam0: {" + lens + "}\n");
    const Imported result = import(dir, options);
    REQUIRE(result.stamps.size() == 6);
    CHECK(result.samples.front().stamp.ns == kFirst);
    REQUIRE(result.warnings.size() == 1);
    CHECK(says(result.warnings[0], "inertial stamps are shifted by 1599999995.020 s so that both begin together"));
    const Calibration kept = load_calibration(dir.file("log/mav0"), "", "");
    CHECK_FALSE(kept.rig.has_right);
    CHECK(kept.noise.rate_hz == Approx(200.0));
    options.cameras = dir.write("two.yaml", "cam0: {" + lens + "}\ncam1: {" + lens + "}\n");
    CHECK(says(input_error_text([&] { import(dir, options); }), "baseline"));
}

TEST_CASE("a video, with the container's stamps or a table's, one camera, two, or both in one") {
    if (!test::can_write_videos()) {
        const test::TempDir dir;
        CHECK(says(input_error_text([&] { import(dir, sources(dir.write("a.mp4", std::string(16, '\0')))); }),
                   "video files need a build with libavformat and libavcodec"));
        return;
    }
    const test::TempDir dir;
    std::string table;
    for (int k = 0; k < 6; ++k) {
        table += fmt::format("{}\n", kFirst + k * kFrameStep);
    }
    const std::string stamps = dir.write("stamps.csv", table);
    const auto grey_of = [](int camera) { return [camera](int k, int, int) { return grey_at(camera, k); }; };
    struct Form {
        const char* name;
        const char* codec;
        const char* format;
        int tolerance;
    };
    for (const Form& form : {Form{"lossless.mkv", "ffv1", "gray", 0}, Form{"film.mp4", "mpeg4", "yuv420p", 6},
                             Form{"film.avi", "mjpeg", "yuvj420p", 3}, Form{"deep.mkv", "ffv1", "gray10le", 0},
                             Form{"colour.mkv", "ffv1", "bgr0", 0}}) {
        CAPTURE(form.name);
        const std::string left = dir.file(std::string("left_") + form.name);
        const std::string right = dir.file(std::string("right_") + form.name);
        test::write_video(left, form.codec, form.format, 64, 32, 6, grey_of(0));
        test::write_video(right, form.codec, form.format, 64, 32, 6, grey_of(1));
        FilesOptions options = sources(left, right);
        options.stamps[0] = stamps;
        check_frames(import(dir, options), true, form.tolerance);
    }
    // Both in one.
    const std::string both = dir.file("both.mkv");
    test::write_video(both, "ffv1", "gray", 64, 32, 6, [](int k, int u, int) { return grey_at(u < 32 ? 0 : 1, k); });
    FilesOptions halves = sources(both);
    halves.stamps[0] = stamps;
    halves.is_side_by_side = true;
    check_frames(import(dir, halves), true);
    // The container's stamps begin at zero: the IMU must, too, or both are aligned.
    FilesOptions own = sources(dir.file("left_film.mp4"));
    const std::string refusal = input_error_text([&] { import(dir, own); });
    CHECK(says(refusal, "images run from 0.000 to 0.250 s and inertial samples from 1599999999.980"));
    CHECK(says(refusal, "--stamps FILE names a table with the frames' stamps by the IMU's clock"));
    own.align_clocks = true;
    const Imported aligned = import(dir, own);
    REQUIRE(aligned.stamps.size() == 6);
    CHECK(aligned.stamps[0] == kFirst - 20'000'000);
    CHECK(aligned.stamps[5] - aligned.stamps[0] == 5 * kFrameStep);
    CHECK(says(aligned.warnings.at(0), "frames are shifted by 1599999999.980 s so that both begin together"));
    own.align_clocks = false;
    own.imu = dir.write("zero.csv", imu_rows([](std::int64_t ns) {
                            return fmt::format("{:.6f},0.1,0.2,0.3,1,2,9.5", static_cast<double>(ns - kFirst) * 1e-9);
                        }));
    CHECK(import(dir, own).stamps.size() == 6);
    // What does not fit.
    own.stamps[0] = dir.write("few.csv", "0.1\n0.2\n");
    CHECK(says(input_error_text([&] { import(dir, own); }), "has 2 stamps, but " + own.images[0] + " has 6 frames"));
    // Cut off while it was written: what is whole is there.
    const std::string noisy = dir.file("noisy.mkv");
    test::write_video(noisy, "ffv1", "gray", 64, 32, 6,
                      [](int k, int u, int v) { return (k * k * 71 + u * u * 13 + v * v * u * 7) % 251; });
    const std::string whole = test::read_file(noisy);
    FilesOptions part = sources(dir.write("cut.mkv", whole.substr(0, whole.size() * 2 / 3)));
    part.align_clocks = true;
    const std::size_t left_over = import(dir, part).stamps.size();
    CHECK(left_over >= 2);
    CHECK(left_over < 6);
    CHECK(is_image_source(dir.file("film.mkv")) == false);
    CHECK(is_image_source(both));
    CHECK_FALSE(is_image_source(dir.write("noise.bin", std::string("\0\1\2\3\4\5\6\7", 8))));
}

}  // namespace facet::import_files_test
