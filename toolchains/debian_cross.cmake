# What the toolchain files of Debian's cross compilers have in common. They set beforehand
#   FACET_TRIPLET        Debian's name of the target, such as aarch64-linux-gnu
#   FACET_ARCHITECTURE   as packages have it, such as arm64
#   FACET_EMULATOR       that runs the target's programs here
# FACET_SYSROOT: the sysroot of scripts/target/sysroot; default: the environment's FACET_SYSROOT, then
# ~/.cache/facet/sysroot-ARCHITECTURE
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_LIBRARY_ARCHITECTURE "${FACET_TRIPLET}")
set(CMAKE_CXX_COMPILER "${FACET_TRIPLET}-g++")

# Projects that CMake makes to try the compiler read these files again and must see the same choice.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES FACET_SYSROOT)

if(NOT FACET_SYSROOT)
  set(_sysroot "$ENV{HOME}/.cache")
  if(DEFINED ENV{XDG_CACHE_HOME})
    set(_sysroot "$ENV{XDG_CACHE_HOME}")
  endif()
  string(APPEND _sysroot "/facet/sysroot-${FACET_ARCHITECTURE}")
  if(DEFINED ENV{FACET_SYSROOT})
    set(_sysroot "$ENV{FACET_SYSROOT}")
  endif()
  set(FACET_SYSROOT "${_sysroot}" CACHE PATH "Debian packages of the target; made by scripts/target/sysroot")
endif()
if(NOT EXISTS "${FACET_SYSROOT}/.facet-sysroot")
  message(FATAL_ERROR "no sysroot in ${FACET_SYSROOT}: run scripts/target/sysroot --architecture "
    "${FACET_ARCHITECTURE}, or set FACET_SYSROOT to where it made one")
endif()
set(CMAKE_SYSROOT "${FACET_SYSROOT}")

# Programs run on the host, everything else comes from the sysroot.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# How ctest runs what was built.
set(CMAKE_CROSSCOMPILING_EMULATOR "${FACET_EMULATOR};-L;${FACET_SYSROOT}")
