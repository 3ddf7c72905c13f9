// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/mask_files.h"

#include <catch2/catch.hpp>
#include <memory>

#include "app/pipeline/frame_pipeline.h"
#include "app/support/png_writer.h"
#include "tests/support/asl_folder.h"
#include "tests/support/input_error_text.h"
#include "tests/support/still_vehicle.h"
#include "tests/support/temp_dir.h"

namespace facet::mask_files_test {
namespace {

std::string write_mask(const test::TempDir& dir, const std::string& name, int width, int height, int black_columns) {
    GreyImage mask;
    mask.resize(width, height);
    for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
        mask.pixels[i] = static_cast<int>(i) % width < black_columns ? 0 : 255;
    }
    REQUIRE(ok(write_png(dir.file(name), mask.view())));
    return dir.file(name);
}

TEST_CASE("a mask beside sensor.yaml belongs to the calibration") {
    const test::TempDir dir;
    for (int camera = 0; camera < 2; ++camera) {
        dir.write("cam" + std::to_string(camera) + "/sensor.yaml", test::asl_camera_yaml(camera));
    }
    dir.write("imu0/sensor.yaml", test::asl_imu_yaml());
    const Calibration without = load_euroc_calibration(dir.path());
    CHECK(without.masks.left.empty());
    const CameraIntrinsics& camera = without.rig.left.intrinsics();
    write_mask(dir, "cam0/mask.png", camera.width, camera.height, 10);
    const Calibration with = load_euroc_calibration(dir.path());
    CHECK(with.masks.left == dir.path() + "/cam0/mask.png");
    CHECK(with.masks.right.empty());
    CHECK(with.files.size() == without.files.size() + 1);
    CHECK(with.files.back().place == "cam0/mask.png");
    const CameraMasks masks = load_masks(with);
    CHECK(masks.left.width == camera.width);
    CHECK(masks.left.pixels[9] == 0);
    CHECK(masks.left.pixels[10] == 255);
    CHECK(masks.right.pixels.empty());
}

TEST_CASE("a mask that cannot be one is an error that names the file") {
    const test::TempDir dir;
    const test::StillVehicle vehicle;
    Calibration calibration;
    calibration.rig = vehicle.rig;
    const CameraIntrinsics& camera = vehicle.rig.left.intrinsics();
    SECTION("missing") { calibration.masks.left = dir.file("none.png"); }
    SECTION("another size") {
        calibration.masks.left = write_mask(dir, "none.png", camera.width - 1, camera.height, 1);
    }
    SECTION("black all over") {
        calibration.masks.right = write_mask(dir, "none.png", camera.width, camera.height, camera.width);
    }
    SECTION("no image") {
        dir.write("none.png", "PNG");
        calibration.masks.right = dir.file("none.png");
    }
    const auto pipeline = std::make_unique<FramePipeline>();
    const std::string text = test::input_error_text([&] { pipeline->configure({}, calibration); });
    CHECK(text.find("none.png") != std::string::npos);
    CHECK(text.find("mask") != std::string::npos);
}

}  // namespace
}  // namespace facet::mask_files_test
