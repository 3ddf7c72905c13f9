# Cross-compilation for 64-bit ARM (Raspberry Pi 3 to 5, i.MX 8, Jetson and alike) with Debian's compiler and the
# sysroot of scripts/target/sysroot. The preset `aarch64` uses it.
#   FACET_SYSROOT    the sysroot; default: the environment's FACET_SYSROOT, then ~/.cache/facet/sysroot-arm64
#   FACET_ARM_TUNE   cortex-a53 (default), cortex-a72 or cortex-a76: the core for which instructions are put in order
# The instruction set is ARMv8.0 with NEON, whatever the tuning: every binary runs on every 64-bit ARM core.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)

# Projects that CMake makes to try the compiler read this file again and must see the same choice.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES FACET_SYSROOT FACET_ARM_TUNE)

if(NOT FACET_SYSROOT)
  set(_sysroot "$ENV{HOME}/.cache")
  if(DEFINED ENV{XDG_CACHE_HOME})
    set(_sysroot "$ENV{XDG_CACHE_HOME}")
  endif()
  string(APPEND _sysroot "/facet/sysroot-arm64")
  if(DEFINED ENV{FACET_SYSROOT})
    set(_sysroot "$ENV{FACET_SYSROOT}")
  endif()
  set(FACET_SYSROOT "${_sysroot}" CACHE PATH "Debian packages of the target; made by scripts/target/sysroot")
endif()
if(NOT EXISTS "${FACET_SYSROOT}/.facet-sysroot")
  message(FATAL_ERROR
    "no sysroot in ${FACET_SYSROOT}: run scripts/target/sysroot, or set FACET_SYSROOT to where it made one")
endif()
set(CMAKE_SYSROOT "${FACET_SYSROOT}")

set(FACET_ARM_TUNE "cortex-a53" CACHE STRING "Core to order instructions for: cortex-a53, cortex-a72 or cortex-a76")
set_property(CACHE FACET_ARM_TUNE PROPERTY STRINGS cortex-a53 cortex-a72 cortex-a76)
if(NOT FACET_ARM_TUNE MATCHES "^cortex-a(53|72|76)$")
  message(FATAL_ERROR "FACET_ARM_TUNE must be cortex-a53, cortex-a72 or cortex-a76, not '${FACET_ARM_TUNE}'")
endif()
set(CMAKE_CXX_FLAGS_INIT "-march=armv8-a -mtune=${FACET_ARM_TUNE}")

# Programs run on the host, everything else comes from the sysroot.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# How ctest runs what was built.
set(CMAKE_CROSSCOMPILING_EMULATOR "qemu-aarch64-static;-L;${FACET_SYSROOT}")
