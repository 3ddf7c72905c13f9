// SPDX-License-Identifier: BSD-2-Clause
// A log folder becomes an MCAP file and the folder again.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>

#include "app/lab/convert/mcap_log.h"
#include "app/lab/convert/pack_log.h"
#include "app/lab/convert/unpack_log.h"
#include "app/mcap/mcap_writer.h"
#include "tests/support/asl_folder.h"
#include "tests/support/input_error_text.h"

namespace facet::convert_test {

namespace fs = std::filesystem;

namespace {

const std::atomic<bool> kGoOn{false};

/// Every file below a folder: relative path and content.
std::map<std::string, std::string> contents(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
        if (entry.is_regular_file()) {
            files[entry.path().lexically_relative(folder).string()] = test::read_file(entry.path().string());
        }
    }
    return files;
}

PackAccount pack(const std::string& folder, const std::string& file, std::vector<std::string>& warnings,
                 Compression compression = Compression::kZstd) {
    PackOptions options;
    options.folder = folder;
    options.file = file;
    options.compression = compression;
    options.library = "test";
    options.warn = [&](const std::string& line) { warnings.push_back(line); };
    return pack_log(options, kGoOn);
}

UnpackAccount unpack(const std::string& file, const std::string& folder) {
    McapLog log(file, [](const std::string& line) { FAIL(line); });
    REQUIRE(log.is_log());
    return unpack_log(
        log, folder, [](std::uint64_t) {}, kGoOn);
}

/// Packs and unpacks; both folders must hold the same. @return the warnings while packing
std::vector<std::string> check_round_trip(const test::TempDir& dir, const std::string& folder) {
    std::vector<std::string> warnings;
    const fs::path out = dir.file("again");
    fs::remove_all(out);
    pack(folder, dir.file("log.mcap"), warnings);
    const UnpackAccount account = unpack(dir.file("log.mcap"), out.string());
    const auto before = contents(folder);
    CHECK(account.files >= before.size());
    CHECK((contents(out.string()) == before));
    return warnings;
}

constexpr const char* kTruth =
    "#timestamp, p_RS_R_x [m]\r\n"
    "1400000000000000000,4.688319,-1.786938,0.783338,0.534108,-0.153029,-0.827383,-0.082152,-0.027876,0.033207,"
    "0.800006,-0.003172,0.021267,0.078502,-0.025266,0.136696,0.075593\r\n"
    "1400000000005000000,4.688177,-1.786770,0.787350,0.534640,-0.152990,-0.826976,-0.082863,-0.029272,0.033992,"
    "0.804771,-0.003172,0.021267,0.078502,-0.025266,0.136696,1e-05\r\n";

}  // namespace

TEST_CASE("a log folder comes back byte for byte") {
    const test::TempDir dir;
    const auto compression = GENERATE(Compression::kNone, Compression::kLz4, Compression::kZstd);
    const std::string log = dir.file("log");
    {
        const test::TempDir made;
        write_asl_folder(made, 6);
        made.write("mav0/state_groundtruth_estimate0/data.csv", kTruth);
        made.write("truth/scene.ply", std::string("ply\0\r\n\xff", 7));
        made.write(".complete", "");
        fs::copy(made.path(), log, fs::copy_options::recursive);
    }
    std::vector<std::string> warnings;
    const PackAccount account = pack(log, dir.file("log.mcap"), warnings, compression);
    CHECK(warnings.empty());
    CHECK(account.messages == std::array<std::uint64_t, 4>{6, 6, 71, 2});
    CHECK(account.attachments == 5);  // three of calibration, the scene, the mark
    CHECK(unpack(dir.file("log.mcap"), dir.file("again")).images == 12);
    CHECK((contents(dir.file("again")) == contents(log)));

    // mav0 itself is a log as well.
    check_round_trip(dir, log + "/mav0/");
}

TEST_CASE("what messages cannot say is kept all the same") {
    const test::TempDir dir;
    const test::TempDir made;
    write_asl_folder(made, 4);
    const std::string left = made.file("mav0/cam0/data.csv");
    const std::string imu = made.file("mav0/imu0/data.csv");
    CHECK(check_round_trip(dir, made.path()).empty());

    SECTION("comments, blanks and no line end") {
        test::replace_line(imu, 5, "# a note\n" + test::asl_imu_row(3));
        made.write("mav0/cam1/data.csv", test::read_file(made.file("mav0/cam1/data.csv")) + "\n\n1,x");
        CHECK(check_round_trip(dir, made.path()).size() == 2);
    }
    SECTION("numbers that JSON does not know, and none at all") {
        test::replace_line(imu, 5, "1400000000000000001,+1.,.5,0,nan,0,9.81");
        test::replace_line(imu, 6, "1400000000000000002,+1.,.5,0,1,0,9.81");
        CHECK(check_round_trip(dir, made.path()).size() == 1);
    }
    SECTION("stamps in disorder") {
        test::replace_line(imu, 9, test::asl_imu_row(3));
        CHECK(check_round_trip(dir, made.path()).empty());
    }
    SECTION("missing, damaged and unlisted images") {
        fs::remove(made.file("mav0/cam0/data/" + test::asl_image_name(1)));
        made.write("mav0/cam0/data/" + test::asl_image_name(2), "no image");
        made.write("mav0/cam1/data/other.png", "unlisted");
        CHECK(check_round_trip(dir, made.path()).size() == 1);
    }
    SECTION("images that are not called by their stamps") {
        fs::rename(made.file("mav0/cam0/data/" + test::asl_image_name(1)), made.file("mav0/cam0/data/frame 1.png"));
        test::replace_line(left, 3, "1400000000050000000,frame 1.png");
        CHECK(check_round_trip(dir, made.path()).empty());
        McapLog log(dir.file("log.mcap"), [](const std::string& line) { FAIL(line); });
        std::vector<std::uint8_t> image;
        CHECK(log.read("mav0/cam0/data/frame 1.png", 1U << 20U, image) == Status::kOk);
        CHECK(text_of(image) == test::read_file(made.file("mav0/cam0/data/frame 1.png")));
    }
    SECTION("names that lead out of the folder") {
        test::replace_line(left, 3, "1400000000050000000,../../imu0/data.csv");
        CHECK(check_round_trip(dir, made.path()).size() == 1);
    }
}

TEST_CASE("single files are found without the others") {
    const test::TempDir dir;
    const test::TempDir made;
    write_asl_folder(made, 3);
    std::vector<std::string> warnings;
    pack(made.path(), dir.file("log.mcap"), warnings);
    McapLog log(dir.file("log.mcap"), [](const std::string& line) { FAIL(line); });
    CHECK(log.has_folder("mav0"));
    CHECK(log.has_folder("mav0/cam1"));
    CHECK_FALSE(log.has_folder("mav0/cam2"));
    std::vector<std::uint8_t> bytes;
    for (const int frame : {2, 0, 1}) {
        const std::string name = "mav0/cam1/data/" + test::asl_image_name(frame);
        REQUIRE(log.read(name, 1U << 20U, bytes) == Status::kOk);
        CHECK(text_of(bytes) == test::read_file(made.file(name)));
        CHECK(log.read(name, 10, bytes) == Status::kFull);
    }
    CHECK(log.read("mav0/cam1/data/7.png", 1U << 20U, bytes) == Status::kNotFound);
    CHECK(log.read("mav0/cam1/data/x", 1U << 20U, bytes) == Status::kNotFound);
    REQUIRE(log.read("mav0/imu0/sensor.yaml", 1U << 20U, bytes) == Status::kOk);
    CHECK(text_of(bytes) == test::read_file(made.file("mav0/imu0/sensor.yaml")));
    CHECK(log.open("mav0/imu0/nothing") == nullptr);
}

TEST_CASE("a file cut off gives what came before, calibration first") {
    const test::TempDir dir;
    const test::TempDir made;
    write_asl_folder(made, 40);
    std::vector<std::string> warnings;
    pack(made.path(), dir.file("log.mcap"), warnings, Compression::kNone);
    const std::string whole = test::read_file(dir.file("log.mcap"));
    const std::string cut = dir.write("cut.mcap", whole.substr(0, whole.size() / 100));
    McapLog log(cut, [&](const std::string& line) { warnings.push_back(line); });
    CHECK_FALSE(warnings.empty());
    std::vector<std::uint8_t> bytes;
    CHECK(log.read("mav0/cam0/sensor.yaml", 1U << 20U, bytes) == Status::kOk);
}

TEST_CASE("nothing is written outside the folder, and nothing is overwritten") {
    const test::TempDir dir;
    const std::string path = dir.file("evil.mcap");
    {
        McapWriter writer(path, Compression::kNone, "facet", "test");
        const std::string file = dir.write("content", "evil");
        for (const char* name : {"../outside", "/tmp/outside", "a/../../outside", "a//b", "", ".", "in/side"}) {
            writer.add_attachment(name, "", file);
        }
        const auto schema = writer.add_schema("foxglove.CompressedImage", "jsonschema", "");
        const auto channel = writer.add_channel(schema, "/cam0", "json",
                                                {{"table", "cam0/data.csv"}, {"names", "file"}, {"line_end", "x"}});
        writer.add_message(channel, 1, R"({"file":"../../../outside","data":"Zm9v"})");
        writer.add_message(channel, 2, R"({"file":"fine.png","data":"Zm9v"})");
        writer.close();
    }
    std::vector<std::string> warnings;
    McapLog log(path, [&](const std::string& line) { warnings.push_back(line); });
    CHECK(warnings.size() == 6);
    unpack_log(
        log, dir.file("out"), [](std::uint64_t) {}, kGoOn);
    CHECK((contents(dir.file("out")) ==
           std::map<std::string, std::string>{{"in/side", "evil"},
                                              {"cam0/data.csv", "1,../../../outside\n2,fine.png\n"},
                                              {"cam0/data/fine.png", "foo"}}));
    CHECK(contents(dir.path()).size() == 5);  // those three, the file and what was attached
    const std::string error = test::input_error_text([&] {
        unpack_log(
            log, dir.file("out"), [](std::uint64_t) {}, kGoOn);
    });
    CHECK(error.find("is not empty") != std::string::npos);
}

TEST_CASE("an interrupted conversion leaves no file") {
    const test::TempDir dir;
    const test::TempDir made;
    write_asl_folder(made, 3);
    PackOptions options;
    options.folder = made.path();
    options.file = dir.file("log.mcap");
    options.warn = [](const std::string&) {};
    const std::atomic<bool> stop{true};
    pack_log(options, stop);
    CHECK(fs::is_empty(dir.path()));
    options.folder = dir.path();
    CHECK(test::input_error_text([&] { pack_log(options, kGoOn); }).find("holds no cam0") != std::string::npos);
    options.folder = dir.file("missing");
    CHECK(test::input_error_text([&] { pack_log(options, kGoOn); }).find("no such folder") != std::string::npos);
}

}  // namespace facet::convert_test
