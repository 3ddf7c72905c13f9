# Cross-compilation for 32-bit ARM with NEON (Raspberry Pi 2, i.MX 6, Zynq 7000, AM57 and alike) with Debian's compiler
# and the sysroot of scripts/target/sysroot --architecture armhf. The preset `armv7` uses it. FACET_SYSROOT: see
# debian_cross.cmake.
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(FACET_TRIPLET arm-linux-gnueabihf)
set(FACET_ARCHITECTURE armhf)
set(FACET_EMULATOR qemu-arm-static)
include("${CMAKE_CURRENT_LIST_DIR}/debian_cross.cmake")
# Every ARMv7 core with NEON, from the Cortex-A8 on. -Wno-psabi: GCC notes where it passes what GCC 6 passed otherwise.
set(CMAKE_CXX_FLAGS_INIT "-march=armv7-a+simd -mfloat-abi=hard -mtune=cortex-a7 -Wno-psabi")
