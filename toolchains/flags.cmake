# Compiler flags of every target: C++20, warnings as errors, an explicit instruction set, reproducible arithmetic.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Debug, Release or RelWithDebInfo" FORCE)
endif()
# Release is CMake's -O3 -DNDEBUG; FACET_ASSERT stays in it. The development build keeps Eigen's and Boost's assertions.
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g")

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CCACHE_PROGRAM}")
endif()

# Instruction set. Never -march=native: a binary must run, and give the same numbers, on another machine than the one
# that built it. It is set for the whole build, not by target, because Eigen's alignment depends on it. These flags go
# to CMAKE_CXX_FLAGS so that `facet info` shows them.
#   x86-64-v3  AVX2 + FMA (Intel Haswell 2013, AMD Excavator 2015 and later)
#   generic    the compiler's default: any x86-64
# Other processors use their toolchain's default.
set(FACET_CODE_FLAGS "")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
  set(FACET_X86_BASELINE "x86-64-v3" CACHE STRING "x86-64 instruction set: x86-64-v3 or generic")
  set_property(CACHE FACET_X86_BASELINE PROPERTY STRINGS x86-64-v3 generic)
  if(FACET_X86_BASELINE STREQUAL "x86-64-v3")
    list(APPEND FACET_CODE_FLAGS -march=x86-64-v3)
  elseif(NOT FACET_X86_BASELINE STREQUAL "generic")
    message(FATAL_ERROR "FACET_X86_BASELINE must be x86-64-v3 or generic, not '${FACET_X86_BASELINE}'")
  endif()
endif()

# No fusing of a*b+c behind our back: whether the compiler fuses depends on inlining, so the last bit would change with
# the build type. Eigen's own kernels and estimator/frontend/simd.h use FMA explicitly and are not affected.
list(APPEND FACET_CODE_FLAGS -ffp-contract=off)
list(JOIN FACET_CODE_FLAGS " " _code_flags)
string(APPEND CMAKE_CXX_FLAGS " ${_code_flags}")

# As packages are built. The same commit gives the same bytes wherever it is built: names of source files, which
# FACET_ASSERT prints, start at the project's root. While developing they do not: an editor finds a file by its whole
# path. The second form is the relative path that ccache gives the compiler if it has a base_dir. The compiler also
# notes the stack frame of every function beside its object, for scripts/target/stack_report; that changes no code.
option(FACET_FOR_PACKAGE "Build as packages are built" ${CMAKE_CROSSCOMPILING})
if(FACET_FOR_PACKAGE)
  file(RELATIVE_PATH _root_from_build "${CMAKE_BINARY_DIR}" "${CMAKE_SOURCE_DIR}")
  add_compile_options(
    "-fmacro-prefix-map=${CMAKE_SOURCE_DIR}/=" "-fmacro-prefix-map=${_root_from_build}/=" -fstack-usage)
endif()

set(FACET_WARNINGS -Wall -Wextra -Werror)
# False alarms of GCC 12: Eigen's AVX loads of the first lanes of a Vector3d, and concatenation of std::string
# (bug 105329).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  list(APPEND FACET_WARNINGS -Wno-array-bounds -Wno-restrict)
endif()

# Programs that use the installed library (install_library.cmake) choose their own warnings. They get the flags above
# that code of headers must share with the library: Eigen's alignment, and the last bit of functions compiled on both
# sides.
add_library(facet_flags INTERFACE)
target_compile_features(facet_flags INTERFACE cxx_std_20)
target_compile_options(facet_flags INTERFACE
  "$<BUILD_INTERFACE:${FACET_WARNINGS}>" "$<INSTALL_INTERFACE:${FACET_CODE_FLAGS}>")
target_include_directories(facet_flags INTERFACE
  "$<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>" "$<INSTALL_INTERFACE:include/facet>")

# For code that neither throws nor asks for types at run time: everything in platform/, estimator/ and mesh/, and the
# drivers of sensors. Link it PRIVATE.
add_library(facet_flags_pure INTERFACE)
target_link_libraries(facet_flags_pure INTERFACE facet_flags)
target_compile_options(facet_flags_pure INTERFACE "$<BUILD_INTERFACE:-fno-exceptions;-fno-rtti>")
