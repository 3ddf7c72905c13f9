// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/asl_log.h"

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <vector>

#include "app/support/input_error.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "tests/support/temp_dir.h"

namespace facet::asl_log_test {
namespace {

constexpr int kSide = 24;

struct Picture {
    explicit Picture(int seed) : pixels(kSide * kSide) {
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            pixels[i] = static_cast<std::uint8_t>(i * 7 + static_cast<std::size_t>(seed));
        }
    }
    ImageView view() const { return {pixels.data(), kSide, kSide, kSide}; }
    bool equals(const ImageView& image) const {
        if (image.width != kSide || image.height != kSide) {
            return false;
        }
        for (int v = 0; v < kSide; ++v) {
            if (!std::equal(image.row(v), image.row(v) + kSide, pixels.begin() + v * kSide)) {
                return false;
            }
        }
        return true;
    }
    std::vector<std::uint8_t> pixels;
};

ImuSample sample_at(std::int64_t ns) {
    const double t = static_cast<double>(ns % 1'000'000'000) * 1e-9;
    return {{ns}, {std::sin(t), -std::exp(t) * 1e-7, 0.0}, {std::sqrt(t), 1.0 / 3.0, 9.81 + t}};
}

/// What a reader gets.
struct ReadLog {
    explicit ReadLog(const std::string& folder) {
        AslDataset log;
        std::string error;
        const AslWarningSink sink = [&](const AslWarning& warning) {
            warnings += warning.kind == AslWarningKind::kMissingRight ? 0 : 1;  // half of them on purpose
        };
        REQUIRE(ok(log.open(folder, {}, sink, error)));
        ImuSample sample;
        StereoFrame frame;
        for (auto event = log.next(sample, frame); event != AslDataset::Event::kEnd; event = log.next(sample, frame)) {
            if (event == AslDataset::Event::kImu) {
                samples.push_back(sample);
                continue;
            }
            frames.push_back(frame.stamp);
            left = left && Picture(static_cast<int>(frames.size())).equals(frame.left);
            rights += frame.right.empty() ? 0 : 1;
        }
    }
    std::vector<ImuSample> samples;
    std::vector<Timestamp> frames;
    bool left = true;  ///< every left image is the picture of its number
    std::size_t rights = 0;
    std::size_t warnings = 0;
};

/// No file can grow beyond a size: what a full disc does, in the middle of a line. Until destroyed.
class SizeLimit {
public:
    explicit SizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        REQUIRE(getrlimit(RLIMIT_FSIZE, &before_) == 0);
        const rlimit limit{bytes, before_.rlim_max};
        REQUIRE(setrlimit(RLIMIT_FSIZE, &limit) == 0);
    }
    ~SizeLimit() {
        (void)setrlimit(RLIMIT_FSIZE, &before_);
        (void)std::signal(SIGXFSZ, handler_);
    }
    SizeLimit(const SizeLimit&) = delete;
    SizeLimit& operator=(const SizeLimit&) = delete;

private:
    rlimit before_{};
    void (*handler_)(int);
};

void add_second(AslLog& log, std::int64_t begin_ns, int& pictures) {
    for (std::int64_t k = 0; k < 200; ++k) {
        log.add_imu(sample_at(begin_ns + k * 5'000'000));
        if (k % 20 == 10) {
            const Timestamp stamp{begin_ns + k * 5'000'000};
            const Picture picture(++pictures);
            log.add_pair({stamp, {stamp, stamp}, {7, 8}, {}}, picture.view(),
                         pictures % 2 == 0 ? ImageView{} : picture.view());
        }
    }
}

TEST_CASE("what is logged is read back bit by bit") {
    const test::TempDir dir;
    int pictures = 0;
    {
        AslLog log(dir.path(), true);
        add_second(log, 1'700'000'000'000'000'000, pictures);
        log.add_edge({{1'700'000'000'000'000'001}, 42, true});
        log.commit();
        CHECK_FALSE(std::filesystem::exists(dir.file("mav0/range0")));
        log.add_range({{1'700'000'000'000'000'002}, {0.1, 0.0, -1.53}}, {1'700'000'000'000'000'009});
        log.commit();
    }
    const ReadLog read(dir.path());
    CHECK(read.warnings == 0);
    REQUIRE(read.samples.size() == 191);  // the reader ends with the last frame
    bool same = true;
    for (std::size_t k = 0; k < read.samples.size(); ++k) {
        const ImuSample sample = sample_at(1'700'000'000'000'000'000 + static_cast<std::int64_t>(k) * 5'000'000);
        same = same && read.samples[k].stamp == sample.stamp && read.samples[k].w_B == sample.w_B &&
               read.samples[k].a_B == sample.a_B;
    }
    CHECK(same);
    CHECK(read.frames.size() == 10);
    CHECK(read.left);
    CHECK(read.rights == 5);
    CHECK(test::read_file(dir.file("mav0/trigger0/data.csv")) ==
          "#timestamp [ns],sequence,rising\n1700000000000000001,42,1\n");
    CHECK(test::read_file(dir.file("mav0/range0/data.csv")) ==
          "#timestamp [ns],x [m],y [m],z [m],given [ns]\n1700000000000000002,0.1,0,-1.53,1700000000000000009\n");
}

TEST_CASE("a log is not overwritten") {
    const test::TempDir dir;
    const AslLog log(dir.path(), false);
    CHECK_THROWS_AS(AslLog(dir.path(), false), InputError);
}

TEST_CASE("rows that do not fit are cut off at the end of a line, and the log stays readable") {
    const test::TempDir dir;
    int pictures = 0;
    AslLog log(dir.path(), true);
    add_second(log, 1'000'000'000, pictures);
    log.commit();
    const std::size_t before = std::filesystem::file_size(dir.file("mav0/imu0/data.csv"));
    {
        const SizeLimit limit(before + 2000);  // in the middle of a line of the next second
        add_second(log, 2'000'000'000, pictures);
        CHECK_THROWS_WITH(log.commit(), Catch::Contains("imu0/data.csv: cannot be written: File too large"));
    }
    const std::string rows = test::read_file(dir.file("mav0/imu0/data.csv"));
    CHECK(rows.size() > before);
    CHECK(rows.size() < before + 2000);
    CHECK(rows.back() == '\n');
    const std::size_t written = ReadLog(dir.path()).samples.size();
    CHECK(written > 200);
    CHECK(written < 400);
    log.commit();  // there is room again: nothing is lost or twice in the file
    const ReadLog read(dir.path());
    CHECK(read.warnings == 0);
    CHECK(read.samples.size() == 391);  // up to the last frame
    CHECK(read.frames.size() == 20);
    CHECK(read.left);
}

TEST_CASE("half an image is no file and no row") {
    const test::TempDir dir;
    AslLog log(dir.path(), true);
    const Picture picture(1);
    const Timestamp stamp{1'000'000'000};
    {
        const SizeLimit limit(100);
        CHECK_THROWS_AS(log.add_pair({stamp, {stamp, stamp}, {}, {}}, picture.view(), picture.view()), InputError);
    }
    log.commit();
    CHECK_FALSE(std::filesystem::exists(dir.file("mav0/cam0/data/1000000000.png")));
    CHECK(test::read_file(dir.file("mav0/cam0/data.csv")) == "#timestamp [ns],filename\n");
}

}  // namespace
}  // namespace facet::asl_log_test
