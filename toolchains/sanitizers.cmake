# FACET_SANITIZE: a comma-separated list for -fsanitize, empty for none. Any finding ends the program.
set(FACET_SANITIZE "" CACHE STRING "Sanitizers of the whole build, e.g. address,undefined or thread")
if(FACET_SANITIZE)
  # vptr: this check of the undefined-behaviour sanitizer needs type information, which the pure libraries do without.
  # maybe-uninitialized, stringop: with instrumented code GCC reports objects that are initialised (std::function) and
  # copies beyond a string's own buffer that never happen (GCC 12). tsan: Boost.Asio's fences, which it cannot see; what
  # they order is ordered by the mutex of Asio's queue, too.
  string(APPEND CMAKE_CXX_FLAGS
    " -fsanitize=${FACET_SANITIZE} -fno-sanitize=vptr -fno-sanitize-recover=all -fno-omit-frame-pointer")
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    string(APPEND CMAKE_CXX_FLAGS " -Wno-maybe-uninitialized -Wno-stringop-overflow -Wno-stringop-overread -Wno-tsan")
  endif()
  # -O1: instrumented code at -O2 takes several times as long to compile, for little speed.
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g")
endif()

# FACET_FUZZ: the fuzzers of tests/fuzz in the place of the tests. What they call is instrumented for coverage.
option(FACET_FUZZ "Build the fuzzers instead of the tests; needs Clang" OFF)
if(FACET_FUZZ)
  string(APPEND CMAKE_CXX_FLAGS " -fsanitize=fuzzer-no-link")
endif()
