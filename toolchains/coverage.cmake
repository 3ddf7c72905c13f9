# FACET_COVERAGE: counts which lines the tests run (scripts/checks/coverage). Counters are not atomic: that would make
# tests of the estimator, which has no threads, many times as slow. Where there are threads, a lost count may hide a
# line or two.
option(FACET_COVERAGE "Count the lines that are run; needs GCC" OFF)
if(FACET_COVERAGE)
  string(APPEND CMAKE_CXX_FLAGS " --coverage -fprofile-abs-path")
  # maybe-uninitialized, stringop: false alarms of GCC 12 with counters between the statements.
  string(APPEND CMAKE_CXX_FLAGS " -Wno-maybe-uninitialized -Wno-stringop-overflow -Wno-stringop-overread")
  # -O1: lines stay apart, and tests that render take minutes instead of an hour.
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1")
endif()
