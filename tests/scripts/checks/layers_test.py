#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/checks/layers.py on small trees made for the purpose."""
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts/checks"))
sys.dont_write_bytecode = True
import layers  # noqa: E402

HEADER = layers.SPDX + "\n// Purpose.\n#pragma once\n"
SOURCE = layers.SPDX + "\n"


class Layers(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        for path in (
            "platform/base/status.h",
            "platform/port/clock.h",
            "drivers/common/axis_map.h",
            "drivers/imu_spi/imu_spi.h",
            "estimator/values/capacity.h",
            "estimator/api/config.h",
            "estimator/geometry/se3.h",
            "estimator/imu/preintegration.h",
            "estimator/window/window.h",
            "estimator/frontend/frontend.h",
            "estimator/values/observation.h",
            "mesh/mesher.h",
            "app/pipeline/frame_pipeline.h",
            "app/lab/eval/alignment.h",
            "tests/support/guard.h",
        ):
            self.write(path)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, path, *includes, text=None):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        start = HEADER if path.endswith(".h") else SOURCE
        file.write_text(text if text is not None else start + "".join(f"#include {i}\n" for i in includes))

    def violations(self):
        return layers.check_tree(self.root)[0]

    def expect_good(self, path, *includes):
        self.write(path, *includes)
        self.assertEqual(self.violations(), [])

    def expect_bad(self, path, include, fragment):
        self.write(path, include)
        found = self.violations()
        self.assertEqual(len(found), 1, found)
        line = 4 if path.endswith(".h") else 2
        self.assertTrue(found[0].startswith(f"{path}:{line}: "), found[0])
        self.assertIn(fragment, found[0])
        (self.root / path).unlink()

    def test_empty_headers_are_good(self):
        self.assertEqual(self.violations(), [])

    def test_the_layers_in_order_are_good(self):
        self.expect_good("estimator/imu/a.cpp", '"estimator/imu/preintegration.h"', '"estimator/geometry/se3.h"')
        self.expect_good("estimator/frontend/a.h", '"estimator/values/capacity.h"', '"platform/base/status.h"',
                         "<vector>")
        self.expect_good("estimator/window/a.h", '"estimator/imu/preintegration.h"', '"estimator/values/observation.h"')
        self.expect_good("mesh/a.cpp", '"estimator/values/capacity.h"', '"estimator/geometry/se3.h"')
        self.expect_good("app/run/a.cpp", '"mesh/mesher.h"', '"drivers/imu_spi/imu_spi.h"', "<thread>",
                         "<yaml-cpp/yaml.h>")
        self.expect_good("app/lab/sim/a.cpp", '"app/pipeline/frame_pipeline.h"', '"app/lab/eval/alignment.h"')
        self.expect_good("drivers/imu_spi/a.cpp", '"platform/port/clock.h"', "<sys/ioctl.h>", "<fmt/core.h>")
        self.expect_good("tests/a.cpp", '"tests/support/guard.h"', '"app/pipeline/frame_pipeline.h"',
                         "<opencv2/core.hpp>", "<thread>")

    def test_layers_upside_down(self):
        self.expect_bad("platform/base/a.h", '"platform/port/clock.h"', "platform/base must not include")

    def test_estimator_does_not_see_mesh(self):
        self.expect_bad("estimator/api/a.h", '"mesh/mesher.h"', "must not include")

    def test_estimator_does_not_see_ports(self):
        self.expect_bad("estimator/api/a.cpp", '"platform/port/clock.h"', "must not include")

    def test_mesh_sees_only_the_values(self):
        self.expect_bad("mesh/a.cpp", '"estimator/window/window.h"', "must not include")
        self.expect_bad("mesh/a.cpp", '"estimator/api/config.h"', "must not include")

    def test_order_inside_the_estimator(self):
        self.expect_bad("estimator/imu/a.h", '"estimator/window/window.h"', "must not include")

    def test_frontend_does_not_see_imu(self):
        self.expect_bad("estimator/frontend/a.cpp", '"estimator/imu/preintegration.h"', "must not include")

    def test_values_see_no_estimator(self):
        self.expect_bad("estimator/values/a.h", '"estimator/api/config.h"', "must not include")

    def test_what_flies_does_not_see_the_lab(self):
        self.expect_bad("app/pipeline/a.cpp", '"app/lab/eval/alignment.h"', "must not include")
        self.expect_bad("app/run/a.cpp", '"app/lab/eval/alignment.h"', "must not include")

    def test_window_does_not_see_the_frontend(self):
        self.expect_bad("estimator/window/a.cpp", '"estimator/frontend/frontend.h"', "must not include")

    def test_drivers_do_not_see_each_other(self):
        self.expect_bad("drivers/replay_asl/a.cpp", '"drivers/imu_spi/imu_spi.h"', "must not include")

    def test_what_drivers_share_sees_no_driver(self):
        self.expect_good("drivers/imu_spi/a.cpp", '"drivers/common/axis_map.h"')
        self.expect_bad("drivers/common/a.cpp", '"drivers/imu_spi/imu_spi.h"', "must not include")

    def test_drivers_do_not_see_the_estimator(self):
        self.expect_bad("drivers/imu_spi/a.cpp", '"estimator/geometry/se3.h"', "must not include")

    def test_nobody_includes_tests(self):
        self.expect_bad("app/commands/a.cpp", '"tests/support/guard.h"', "must not include")

    def test_paths_start_at_the_root(self):
        self.expect_bad("estimator/geometry/a.cpp", '"se3.h"', "project root")

    def test_includes_exist(self):
        self.expect_bad("estimator/geometry/a.cpp", '"estimator/geometry/nothing.h"', "does not exist")

    def test_headers_made_by_cmake_have_a_template(self):
        self.write("app/build_info.h.in", text="")
        self.expect_good("app/commands/a.cpp", '"app/build_info.h"')

    def test_pure_code_has_no_clock_thread_file_or_log(self):
        for header in ("thread", "chrono", "ctime", "iostream", "fstream", "cstdio", "sys/time.h", "unistd.h"):
            with self.subTest(header):
                self.expect_bad("mesh/a.h", f"<{header}>", "no clock")
                self.expect_good("mesh/a.h", "<cstdint>")
                self.expect_bad("estimator/imu/a.cpp", f"<{header}>", "no clock")
                self.expect_good("estimator/imu/a.cpp")

    def test_opencv_stays_in_the_frontend(self):
        self.expect_good("estimator/frontend/a.cpp", "<opencv2/core.hpp>")
        self.expect_good("estimator/frontend/a_impl.h", "<opencv2/core.hpp>")
        self.expect_good("estimator/frontend/internal/b.h", "<opencv2/core.hpp>")
        self.expect_bad("estimator/frontend/a.h", "<opencv2/core.hpp>", "in a header")
        self.expect_good("estimator/frontend/a.h")
        self.expect_bad("app/commands/a.cpp", "<opencv2/core.hpp>", "only for estimator/frontend")

    def test_private_headers_of_the_frontend_stay_there(self):
        self.write("estimator/frontend/a_impl.h", "<opencv2/core.hpp>")
        self.expect_bad("estimator/api/a.cpp", '"estimator/frontend/a_impl.h"', "private")

    def test_third_party_stays_at_the_edges(self):
        self.expect_bad("drivers/imu_spi/a.cpp", "<yaml-cpp/yaml.h>", "only for app")
        self.expect_good("drivers/imu_spi/a.cpp")
        self.expect_bad("drivers/imu_spi/a.cpp", "<png.h>", "only for app, drivers/replay_asl")
        self.expect_good("drivers/imu_spi/a.cpp")
        self.expect_good("drivers/replay_asl/a.cpp", "<png.h>")

    def test_rules_on_single_files(self):
        self.write("app/commands/a.h", text="#pragma once\n")
        self.assertEqual(len(self.violations()), 2)  # SPDX, purpose
        self.write("app/commands/a.h", text=layers.SPDX + "\n// Purpose.\n")
        self.assertIn("#pragma once", self.violations()[0])

    def test_files_that_fly_have_400_lines_and_others_500(self):
        for path, limit in (("app/commands/a.cpp", 400), ("platform/port/a.cpp", 400), ("app/lab/sim/a.cpp", 500),
                            ("tests/mesh/a.cpp", 500)):
            with self.subTest(path):
                self.write(path, text=SOURCE + "\n" * (limit - 1))
                self.assertEqual(self.violations(), [])
                self.write(path, text=SOURCE + "\n" * limit)
                self.assertEqual(len(self.violations()), 1)
                self.assertIn(f"split the file ({limit} at most)", self.violations()[0])
                (self.root / path).unlink()

    def test_the_example_of_the_library_sees_what_is_installed(self):
        self.expect_good("docs/example/main.cpp", '"estimator/api/config.h"', '"mesh/mesher.h"')
        self.expect_bad("docs/example/main.cpp", '"app/pipeline/frame_pipeline.h"', "docs/example must not include")

    def test_a_new_folder_needs_a_rule(self):
        self.write("estimator/novelty/a.cpp")
        self.assertIn("no include rule", self.violations()[0])


if __name__ == "__main__":
    unittest.main()
