// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/map_thread.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <thread>

#include "tests/mesh/depth/stereo_scene.h"
#include "tests/support/allocation_guard.h"

namespace facet::map_thread_test {
namespace {

/// Counts the triangles that it is given.
struct CountingSurface final : SurfaceSink {
    std::atomic<std::size_t> triangles{0};
    void take(const SurfacePiece& piece, std::uint32_t /*restart*/) override { triangles += piece.triangles.size(); }
};

MapConfig few_blocks() {
    MapConfig config;
    config.square_px = 4;  // of images of 320 x 240
    config.max_blocks = 512;
    return config;
}

/// Keyframes along a wall.
struct Walk {
    std::unique_ptr<KeyframeView> view = std::make_unique<KeyframeView>();
    test::SceneImage left;
    test::SceneImage right;

    void step() {
        const Eigen::Vector3d place(0.15 * view->number, 0.0, 0.0);
        left = test::draw(wall_, place);
        right = test::draw(wall_, place + Eigen::Vector3d(0.1, 0.0, 0.0));
        ++view->number;
        view->stamp = Timestamp{static_cast<std::int64_t>(view->number) * 100'000'000};
        view->T_W_C0.p = place;
        view->keyframes.push_back({view->stamp, view->T_W_C0});
    }

private:
    test::Surface wall_ = test::plane_surface(Eigen::Vector3d::UnitZ(), 2.0);
};

TEST_CASE("keyframes wait for the map's thread without heap or delay; those that come too fast are counted") {
    CountingSurface surface;
    MapThread thread(few_blocks(), test::scene_rig(), surface);
    Walk walk;
    for (std::size_t i = 0; i < MapThread::kSlots + 2; ++i) {
        walk.step();
        const test::AllocationGuard guard;
        thread.take(*walk.view, 0, walk.left.view(), walk.right.view());
        const std::uint64_t allocations = guard.allocations();
        CHECK(allocations == 0);
    }
    CHECK(thread.dropped() == 2);
    CHECK(surface.triangles == 0);
    thread.finish();
    CHECK(thread.map().counters().integrated == MapThread::kSlots);
    CHECK(surface.triangles > 1000);
}

TEST_CASE("the map's thread gives surface while keyframes come, and ends when it is to stop") {
    CountingSurface surface;
    MapThread thread(few_blocks(), test::scene_rig(), surface);
    std::atomic<bool> stopping{false};
    std::thread worker([&] { thread.work(stopping); });
    Walk walk;
    int keyframes = 0;
    // What is settled is shown four keyframes later; 200 are twenty seconds.
    for (; keyframes < 200 && surface.triangles < 1000; ++keyframes) {
        if (keyframes < static_cast<int>(kMaxKeyframes)) {
            walk.step();
        }
        thread.take(*walk.view, 0, walk.left.view(), walk.right.view());
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    CHECK(surface.triangles >= 1000);
    stopping = true;
    worker.join();
    thread.finish();
    const MapCounters& counters = thread.map().counters();
    CHECK(counters.keyframes + counters.skipped + thread.dropped() == static_cast<std::uint64_t>(keyframes));
}

TEST_CASE("a keyframe without one of its images, or of another size, is left out") {
    CountingSurface surface;
    MapThread thread(few_blocks(), test::scene_rig(), surface);
    Walk walk;
    walk.step();
    thread.take(*walk.view, 0, walk.left.view(), {});
    ImageView large = walk.right.view();
    large.width *= 4;
    walk.step();
    thread.take(*walk.view, 0, walk.left.view(), large);
    thread.finish();
    CHECK(thread.map().counters().skipped == 2);
    CHECK(thread.map().counters().integrated == 0);
}

}  // namespace
}  // namespace facet::map_thread_test
