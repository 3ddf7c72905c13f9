# FACET_COVERAGE: counts which lines the tests run (scripts/coverage). Atomic counters: tests have threads.
option(FACET_COVERAGE "Count the lines that are run; needs GCC" OFF)
if(FACET_COVERAGE)
  string(APPEND CMAKE_CXX_FLAGS " --coverage -fprofile-update=atomic -fprofile-abs-path")
  # maybe-uninitialized, stringop: false alarms of GCC 12 with counters between the statements.
  string(APPEND CMAKE_CXX_FLAGS " -Wno-maybe-uninitialized -Wno-stringop-overflow -Wno-stringop-overread")
  # -O1: lines stay apart, and tests that render take minutes instead of an hour.
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1")
endif()
