// SPDX-License-Identifier: BSD-2-Clause
// A reader is given the same by a log folder and by the MCAP file made of it.
#include "app/lab/convert/opened_log.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "app/lab/convert/pack_log.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "drivers/replay_asl/ground_truth.h"
#include "tests/support/asl_folder.h"
#include "tests/support/input_error_text.h"

namespace facet::opened_log_test {

namespace fs = std::filesystem;

namespace {

void pack(const std::string& folder, const std::string& file) {
    PackOptions options;
    options.folder = folder;
    options.file = file;
    options.warn = [](const std::string&) {};
    const std::atomic<bool> stop{false};
    pack_log(options, stop);
}

std::string text_of_image(const ImageView& image) {
    std::string text = fmt::format("{}x{}:", image.width, image.height);
    for (int v = 0; v < image.height; ++v) {
        text.append(reinterpret_cast<const char*>(image.row(v)), static_cast<std::size_t>(image.width));
    }
    return text;
}

/// All that a reader gives, warnings included, with the log's own path replaced.
std::vector<std::string> reading_of(const std::string& path, const OpenedLog& opened, int loops = 1) {
    std::vector<std::string> given;
    const auto keep = [&](std::string line) {
        for (std::size_t at = 0; (at = line.find(path)) != std::string::npos;) {
            line.replace(at, path.size(), "LOG");
        }
        given.push_back(line);
    };
    AslOptions options;
    options.files = opened.files();
    options.loops = loops;
    AslDataset log;
    std::string error;
    if (!ok(log.open(
            path, options, [&](const AslWarning& warning) { keep(warning.text()); }, error))) {
        keep(error);
        return given;
    }
    ImuSample sample;
    StereoFrame frame;
    for (;;) {
        switch (log.next(sample, frame)) {
            case AslDataset::Event::kImu:
                given.push_back(fmt::format("{} {} {}", sample.stamp.ns, sample.w_B.z(), sample.a_B.z()));
                break;
            case AslDataset::Event::kFrame:
                given.push_back(fmt::format("{} ", frame.stamp.ns) + text_of_image(frame.left) +
                                text_of_image(frame.right));
                break;
            case AslDataset::Event::kEnd: return given;
        }
    }
}

void check_same_reading(const std::string& folder, const std::string& file, int loops = 1) {
    pack(folder, file);
    const OpenedLog from_folder(folder, [](const std::string& line) { FAIL(line); });
    const OpenedLog from_file(file, [](const std::string& line) { FAIL(line); });
    CHECK(from_folder.files() == nullptr);
    CHECK(from_folder.folder() == folder);
    REQUIRE(from_file.files() != nullptr);
    const std::vector<std::string> expected = reading_of(folder, from_folder, loops);
    CHECK(expected.size() > 50);
    CHECK(reading_of(file, from_file, loops) == expected);
    const auto yaml = [](const OpenedLog& log) { return test::read_file(log.root() + "/cam1/sensor.yaml"); };
    CHECK(yaml(from_file) == yaml(from_folder));
}

}  // namespace

TEST_CASE("an MCAP file is read as the folder is") {
    const test::TempDir dir;
    const test::TempDir made;
    write_asl_folder(made, 8);
    const std::string file = dir.file("log.mcap");
    check_same_reading(made.path(), file);
    check_same_reading(made.path(), file, 3);
    check_same_reading(made.file("mav0"), file);

    // Damaged, with the same warnings.
    const std::string left = "mav0/cam0/data/";
    fs::remove(made.file(left + test::asl_image_name(2)));
    made.write(left + test::asl_image_name(3), "no image");
    test::replace_line(made.file("mav0/imu0/data.csv"), 9, "1,2,3");
    test::replace_line(made.file("mav0/cam1/data.csv"), 4, "");
    check_same_reading(made.path(), file);

    fs::remove_all(made.file("mav0/cam1/data"));
    made.write("mav0/cam1/data.csv", "#\n");
    pack(made.path(), file);
    const auto nothing = [](const std::string&) {};
    CHECK(reading_of(file, OpenedLog(file, nothing)) == reading_of(made.path(), OpenedLog(made.path(), nothing)));
}

TEST_CASE("small files lie in a folder that goes with the object") {
    const test::TempDir dir;
    const test::TempDir made;
    write_asl_folder(made, 3);
    made.write("mav0/state_groundtruth_estimate0/data.csv", "#\n5,1,2,3,1,0,0,0\n");
    made.write("truth/scene.ply", "a scene");
    pack(made.path(), dir.file("log.mcap"));
    std::string folder;
    {
        const OpenedLog log(dir.file("log.mcap"), [](const std::string& line) { FAIL(line); });
        folder = log.folder();
        CHECK(test::read_file(folder + "/truth/scene.ply") == "a scene");
        CHECK(test::read_file(find_ground_truth(folder)) == "#\n5,1,2,3,1,0,0,0\n");
        CHECK_FALSE(fs::exists(folder + "/mav0/imu0/data.csv"));
    }
    CHECK_FALSE(fs::exists(folder));
}

TEST_CASE("images say the command that makes a log of them, and a log the size of its own") {
    const test::TempDir dir;
    const auto open = [&](const std::string& path) {
        return test::input_error_text([&] { OpenedLog(path, [](const std::string&) {}); });
    };
    const std::string list = dir.write("rgb.txt", "# timestamp filename\n1.0 rgb/1.png\n");
    CHECK(open(list).find("facet convert " + list + " rgb_log --imu imu.csv") != std::string::npos);
    dir.write("shots/1.jpg", test::encode_jpeg(20, 10, 1, 90));
    CHECK(open(dir.file("shots")).find("shots: holds images, of which facet convert makes a log") != std::string::npos);
    CHECK(extent_of_images(dir.file("shots"), nullptr) == ImageExtent{});
    dir.write("desk/rgb.txt", "# timestamp filename\n1.0 rgb/1.png\n");
    CHECK(open(dir.file("desk")).find("facet convert " + dir.file("desk/rgb.txt") + " rgb_log") != std::string::npos);
    test::write_asl_folder(dir, 3);
    std::filesystem::remove(dir.file("mav0/cam0/data/" + std::to_string(test::kAslBegin) + ".png"));
    CHECK(extent_of_images(dir.path(), nullptr) == ImageExtent{test::kAslWidth, test::kAslHeight});
    pack(dir.path(), dir.file("log.mcap"));
    const OpenedLog packed(dir.file("log.mcap"), [](const std::string&) {});
    CHECK(extent_of_images(dir.file("log.mcap"), packed.files()) == ImageExtent{test::kAslWidth, test::kAslHeight});
}

TEST_CASE("refuses what is not a log in one line") {
    const test::TempDir dir;
    const auto open = [&](const std::string& path) {
        return test::input_error_text([&] { OpenedLog(path, [](const std::string&) {}); });
    };
    CHECK(open(dir.file("missing")).find("no such folder") != std::string::npos);
    CHECK(open(dir.write("text", "text"))
              .find("text: is not a log: neither a folder, nor an MCAP file of one, nor a bag") != std::string::npos);
    // A bag, a folder with a bag and a folder of logs say what to type instead.
    const std::string bag = dir.write("field/flight.bag", "#ROSBAG V2.0\n");
    CHECK(open(bag).find("facet convert " + bag + " flight_log && facet replay flight_log --out result") !=
          std::string::npos);
    CHECK(open(dir.file("field")).find("is a bag, of which facet convert makes a log") != std::string::npos);
    dir.write("rooms/b/mav0/cam0/data.csv", "");
    dir.write("rooms/a/cam0/data.csv", "");
    CHECK(open(dir.file("rooms")).find("is not a log but contains some: " + dir.file("rooms/a") + " is one") !=
          std::string::npos);
    dir.write("pictures/1.png", "");
    CHECK(open(dir.file("pictures")).find("has neither cam0/data.csv nor mav0/cam0/data.csv") != std::string::npos);
}

}  // namespace facet::opened_log_test
