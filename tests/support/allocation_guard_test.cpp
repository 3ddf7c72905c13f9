// SPDX-License-Identifier: BSD-2-Clause
#include "tests/support/allocation_guard.h"

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <thread>

namespace facet::test::allocation_guard_test {
namespace {

/// Runs f and gives its allocations.
template <class F>
std::uint64_t count(const F& f) {
    const AllocationGuard guard;
    f();
    return guard.allocations();
}

/// Keeps the optimiser from removing a pair of allocation and release.
void keep(const volatile void* p) { asm volatile("" : : "g"(p) : "memory"); }

TEST_CASE("every way to the heap counts", "[allocation_guard]") {
    const std::uint64_t one = AllocationGuard::active() ? 1 : 0;
    CHECK(count([] {
              auto p = std::make_unique<int>(1);
              keep(p.get());
          }) == one);
    CHECK(count([] {
              struct alignas(64) Wide {
                  char c[64];
              };
              auto p = std::make_unique<Wide>();
              keep(p.get());
          }) == one);
    CHECK(count([] {
              void* p = std::calloc(3, 5);
              keep(p);
              std::free(p);
          }) == one);
    CHECK(count([] {
              void* p = nullptr;
              const int failed = posix_memalign(&p, 64, 100);
              keep(p);
              if (failed == 0) {
                  std::free(p);
              }
          }) == one);
    // Both inside a shared library: libstdc++'s string, and an Eigen matrix of dynamic size.
    const std::string text(100, 'x');
    CHECK(count([&] {
              const std::string copy(text);
              keep(copy.data());
          }) == one);
    CHECK(count([] {
              const Eigen::MatrixXd m = Eigen::MatrixXd::Zero(20, 20);
              keep(m.data());
          }) == one);
}

TEST_CASE("the stack does not count", "[allocation_guard]") {
    CHECK(count([] {
              const Eigen::Matrix<double, 30, 30> m = Eigen::Matrix<double, 30, 30>::Identity();
              const Eigen::Matrix<double, 30, 30> n = m * m;
              keep(n.data());
          }) == 0);
}

TEST_CASE("guards nest, count bytes and see their own thread only", "[allocation_guard]") {
    const std::uint64_t one = AllocationGuard::active() ? 1 : 0;
    const AllocationGuard outer;
    void* const a = ::operator new(10);
    const AllocationGuard inner;
    void* const b = ::operator new(1000);
    const std::uint64_t inner_count = inner.allocations();
    const std::uint64_t inner_bytes = inner.bytes();
    const std::uint64_t outer_count = outer.allocations();
    ::operator delete(a);
    ::operator delete(b);
    CHECK(inner_count == one);
    CHECK(inner_bytes == 1000 * one);
    CHECK(outer_count == 2 * one);

    const AllocationGuard guard;
    std::thread other([] {
        for (int i = 0; i < 100; ++i) {
            keep(std::make_unique<int>(i).get());
        }
    });
    other.join();
    const std::uint64_t here = guard.allocations();
    CHECK(here < 50);  // starting the thread allocates a little here; its hundred are its own
}

TEST_CASE("the first allocation's call stack is kept", "[allocation_guard]") {
    const AllocationGuard none;
    CHECK(none.first_allocation().empty());
    const AllocationGuard guard;
    const auto p = std::make_unique<int>(1);
    keep(p.get());
    const std::string stack = guard.first_allocation();
    CHECK(stack.empty() != AllocationGuard::active());
    if (AllocationGuard::active()) {
        CHECK(stack.find("allocation_guard_test") != std::string::npos);
    }
}

}  // namespace
}  // namespace facet::test::allocation_guard_test
