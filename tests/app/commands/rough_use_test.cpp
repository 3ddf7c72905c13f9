// SPDX-License-Identifier: BSD-2-Clause
// Rough use of the program: results of earlier runs, output that cannot be written, a closed terminal, logs that lack
// most or hold what is none.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/app/commands/run_program.h"
#include "tests/support/asl_folder.h"
#include "tests/support/temp_dir.h"

namespace facet::rough_use_test {
namespace {

using test::contains;
using test::count_lines;
using test::Outcome;
using test::run;
using test::shell;

/// So few frames need not give an estimate, but any exit code but 0 and 1 is a crash.
bool has_ended_by_itself(int code) { return code == 0 || code == 1; }

TEST_CASE("a replay that is refused leaves the results of the one before it alone") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 5);
    const std::string replay = "replay " + dir.path() + " --quiet --out " + dir.file("out");
    REQUIRE(has_ended_by_itself(run(dir, replay).code));
    const std::string health = test::read_file(dir.file("out/health.csv"));
    REQUIRE(count_lines(health) == 6);
    CHECK(run(dir, replay + " --start 1000").code == 2);
    CHECK(run(dir, replay + " --set frontend.window_px=20").code == 2);
    CHECK(test::read_file(dir.file("out/health.csv")) == health);
    CHECK_FALSE(std::filesystem::exists(dir.file("out/health.csv.part")));
}

TEST_CASE("output that cannot be written never ends a run, and is reported") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 5);
    std::filesystem::remove(dir.file("mav0/cam0/data/" + test::asl_image_name(2)));  // a warning
    const std::string replay = "$FACET replay . --out out ";
    const auto ran_to_its_end = [&] {
        const bool all = std::filesystem::exists(dir.file("out/summary.json")) &&
                         count_lines(test::read_file(dir.file("out/health.csv"))) == 6;
        std::filesystem::remove_all(dir.file("out"));
        return all;
    };
    CHECK(has_ended_by_itself(shell(dir, replay + ">log 2>/dev/full")));
    CHECK(ran_to_its_end());
    CHECK(has_ended_by_itself(shell(dir, replay + "2>&1 >log | true")));
    CHECK(ran_to_its_end());
    CHECK(has_ended_by_itself(shell(dir, replay + "<&- >&- 2>&-")));
    const std::string tum = test::read_file(dir.file("out/trajectory.tum"));
    CHECK_FALSE(contains(tum, "frames"));
    CHECK(ran_to_its_end());
    CHECK(shell(dir, "$FACET info --config >/dev/full 2>err") == 1);
    CHECK(contains(test::read_file(dir.file("err")), "standard output: cannot be written"));
    CHECK(shell(dir, "{ $FACET info --config; echo $? >code; } | true") == 0);  // its reader wants no more
    CHECK(test::read_file(dir.file("code")) == "0\n");
    // A path that is no UTF-8 ends up in the summary somehow.
    CHECK(has_ended_by_itself(shell(dir,
                                    "mv mav0 $(printf 'mav\\351'); $FACET replay $(printf 'mav\\351') --out out >log "
                                    "2>&1")));
    CHECK(ran_to_its_end());
}

TEST_CASE("a log of which most is lost is exit code 1 and a sentence why") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 20);
    std::string reversed = "#stamp,file\n";
    for (int k = 19; k >= 0; --k) {
        reversed += test::asl_image_row(k) + "\n";
    }
    dir.write("mav0/cam0/data.csv", reversed);
    const Outcome outcome = run(dir, "replay " + dir.path() + " --quiet --out " + dir.file("out"));
    INFO(outcome.err);
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.err, "19 rows of cam0/data.csv skipped"));
    CHECK(nlohmann::json::parse(test::read_file(dir.file("out/summary.json")))["frames_listed"] == 20);
}

TEST_CASE("skips or refuses in one line what is not an image or far too large") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 5);
    const auto image = [](int k) { return "mav0/cam0/data/" + test::asl_image_name(k); };
    REQUIRE(shell(dir, "rm " + image(1) + " " + image(2) + "; mkfifo " + image(1) + "; ln -s /dev/zero " + image(2) +
                           "; truncate -s 3G " + image(3)) == 0);
    CHECK(has_ended_by_itself(run(dir, "replay " + dir.path() + " --quiet --out " + dir.file("out")).code));
    CHECK(count_lines(test::read_file(dir.file("out/health.csv"))) == 6);
    CHECK(count_lines(test::read_file(dir.file("out/warnings.txt"))) == 3);
    REQUIRE(shell(dir, "truncate -s 3G mav0/imu0/sensor.yaml") == 0);
    const Outcome refused = run(dir, "replay " + dir.path() + " --out " + dir.file("other"));
    CHECK(refused.code == 2);
    CHECK(contains(refused.err, "imu0/sensor.yaml: has 3072 MiB, more than the "));
    CHECK(count_lines(refused.err) == 1);
}

TEST_CASE("a terminal that is closed ends a replay in order") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 100);  // 5 s
    const int code = shell(dir,
                           "$FACET replay . --realtime --quiet --out out >log 2>&1 & "
                           "until [ -e out/health.csv.part ]; do kill -0 $! || exit 9; sleep 0.01; done; "
                           "kill -HUP $!; wait $!");
    CHECK(code == 1);
    const auto summary = nlohmann::json::parse(test::read_file(dir.file("out/summary.json")));
    CHECK(summary["interrupted"] == true);
    CHECK(summary["frames"] < 100);
    CHECK_FALSE(std::filesystem::exists(dir.file("out/health.csv.part")));
}

TEST_CASE("reports why a log has no estimate, where its accelerometer shows it") {
    const struct {
        const char* reading;
        const char* sentence;
    } cases[] = {{"1.0", "reads 1.00 at rest: it is in g"},
                 {"0", "reads 0.00 m/s^2 at rest: gravity has been taken out"}};
    for (const auto& c : cases) {
        const test::TempDir dir;
        test::write_asl_folder(dir, 40);
        REQUIRE(shell(dir, std::string("sed -i 's/,9.81$/,") + c.reading + "/' mav0/imu0/data.csv") == 0);
        const Outcome outcome = run(dir, "replay " + dir.path() + " --quiet --out " + dir.file("out"));
        INFO(outcome.err);
        CHECK(outcome.code == 1);
        CHECK(contains(outcome.err, "no estimate at all of 40 frames"));
        CHECK(contains(outcome.err, std::string("the log shows a cause: gravity: the accelerometer ") + c.sentence));
    }
}

}  // namespace
}  // namespace facet::rough_use_test
