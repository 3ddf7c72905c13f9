# Cross-compilation for 64-bit ARM (Raspberry Pi 3 to 5, i.MX 8, Jetson and alike) with Debian's compiler and the
# sysroot of scripts/target/sysroot. The preset `aarch64` uses it.
#   FACET_SYSROOT    see debian_cross.cmake
#   FACET_ARM_TUNE   cortex-a53 (default), cortex-a72 or cortex-a76: the core for which instructions are put in order
# The instruction set is ARMv8.0 with NEON, whatever the tuning: every binary runs on every 64-bit ARM core.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(FACET_TRIPLET aarch64-linux-gnu)
set(FACET_ARCHITECTURE arm64)
set(FACET_EMULATOR qemu-aarch64-static)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES FACET_ARM_TUNE)
include("${CMAKE_CURRENT_LIST_DIR}/debian_cross.cmake")

set(FACET_ARM_TUNE "cortex-a53" CACHE STRING "Core to order instructions for: cortex-a53, cortex-a72 or cortex-a76")
set_property(CACHE FACET_ARM_TUNE PROPERTY STRINGS cortex-a53 cortex-a72 cortex-a76)
if(NOT FACET_ARM_TUNE MATCHES "^cortex-a(53|72|76)$")
  message(FATAL_ERROR "FACET_ARM_TUNE must be cortex-a53, cortex-a72 or cortex-a76, not '${FACET_ARM_TUNE}'")
endif()
set(CMAKE_CXX_FLAGS_INIT "-march=armv8-a -mtune=${FACET_ARM_TUNE}")
