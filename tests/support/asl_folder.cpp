// SPDX-License-Identifier: BSD-2-Clause
#include "tests/support/asl_folder.h"

#include <png.h>

#include <sstream>
#include <stdexcept>

#include "tests/support/jpeg_writer.h"

namespace facet::test {
namespace {

void append_bytes(png_structp png, png_bytep data, png_size_t size) {
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), size);
}

std::string image_csv(int frames) {
    std::string text = "#timestamp [ns],filename\n";
    for (int k = 0; k < frames; ++k) {
        text += asl_image_row(k) + "\n";
    }
    return text;
}

}  // namespace

std::string encode_png(int width, int height, int channels, int bits, const std::vector<std::uint16_t>& samples) {
    constexpr int kColour[] = {0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                               PNG_COLOR_TYPE_RGBA};
    std::string bytes;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(png, &bytes, append_bytes, nullptr);
    png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bits, kColour[channels],
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    const std::size_t row_samples = static_cast<std::size_t>(width) * static_cast<std::size_t>(channels);
    std::vector<png_byte> row;
    for (std::size_t v = 0; v < static_cast<std::size_t>(height); ++v) {
        row.clear();
        for (std::size_t i = 0; i < row_samples; ++i) {
            const std::uint16_t sample = samples.at(v * row_samples + i);
            if (bits == 16) {
                row.push_back(static_cast<png_byte>(sample >> 8U));
            }
            row.push_back(static_cast<png_byte>(sample & 0xffU));
        }
        png_write_row(png, row.data());
    }
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    return bytes;
}

std::string encode_jpeg(int width, int height, int channels, std::uint8_t value) {
    const std::vector<std::uint8_t> bytes = write_jpeg(
        width, height, channels == 3 ? JCS_RGB : JCS_GRAYSCALE, [](jpeg_compress_struct&) {},
        [&](int) { return std::vector<std::uint8_t>(static_cast<std::size_t>(channels * width), value); });
    return {bytes.begin(), bytes.end()};
}

std::uint8_t asl_pixel(int camera, int frame, int u, int v) {
    return static_cast<std::uint8_t>(100 * camera + 17 * frame + 3 * u + 5 * v + u * v / 7);
}

std::string asl_image_name(int frame) { return std::to_string(kAslBegin + frame * kAslFrameStep) + ".png"; }

std::string asl_image_row(int frame) {
    return std::to_string(kAslBegin + frame * kAslFrameStep) + "," + asl_image_name(frame);
}

std::string asl_imu_row(int sample) {
    return std::to_string(kAslBegin - kAslFrameStep + sample * kAslImuStep) + ",0,0,0.01,0,0,9.81";
}

std::string asl_camera_yaml(int camera) {
    return std::string("%YAML:1.0\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, ") +
           (camera == 0 ? "0.0" : "0.1") +
           ",\n         0, 1, 0, 0,\n         0, 0, 1, 0,\n         0, 0, 0, 1]\nrate_hz: 20\nresolution: [160, 120]\n"
           "camera_model: pinhole\nintrinsics: [150.0, 150.0, 79.5, 59.5]\ndistortion_model: radial-tangential\n"
           "distortion_coefficients: [-0.1, 0.01, 0.0, 0.0]\n";
}

std::string asl_imu_yaml() {
    return "%YAML:1.0\nsensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0,\n         0, 1, 0, 0,\n"
           "         0, 0, 1, 0,\n         0, 0, 0, 1]\nrate_hz: 200\ngyroscope_noise_density: 1.7e-4\n"
           "gyroscope_random_walk: 1.9e-5\naccelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n";
}

void write_asl_folder(const TempDir& dir, int frames) {
    for (int camera = 0; camera < 2; ++camera) {
        const std::string folder = "mav0/cam" + std::to_string(camera) + "/";
        dir.write(folder + "data.csv", image_csv(frames));
        dir.write(folder + "sensor.yaml", asl_camera_yaml(camera));
        for (int k = 0; k < frames; ++k) {
            std::vector<std::uint16_t> samples;
            for (int v = 0; v < kAslHeight; ++v) {
                for (int u = 0; u < kAslWidth; ++u) {
                    samples.push_back(asl_pixel(camera, k, u, v));
                }
            }
            dir.write(folder + "data/" + asl_image_name(k), encode_png(kAslWidth, kAslHeight, 1, 8, samples));
        }
    }
    std::string imu = "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
    const int samples = static_cast<int>(kAslFrameStep / kAslImuStep) * (frames + 1);
    for (int i = 0; i <= samples; ++i) {
        imu += asl_imu_row(i) + "\n";
    }
    dir.write("mav0/imu0/data.csv", imu);
    dir.write("mav0/imu0/sensor.yaml", asl_imu_yaml());
}

void replace_line(const std::string& path, int line, const std::string& text) {
    std::istringstream old(read_file(path));
    std::string result;
    std::string row;
    int current = 0;
    while (std::getline(old, row)) {
        if (++current != line) {
            result += row + "\n";
        } else if (!text.empty()) {
            result += text + "\n";
        }
    }
    if (current < line) {
        throw std::runtime_error(path + " has no line " + std::to_string(line));
    }
    std::ofstream(path, std::ios::binary) << result;
}

}  // namespace facet::test
