# libgpiod as Gpiod::gpiod, and in Gpiod_API which generation of its interface the header has: 1 (1.6, Debian 12) or 2.
find_path(Gpiod_INCLUDE_DIR gpiod.h)
find_library(Gpiod_LIBRARY gpiod)
if(Gpiod_INCLUDE_DIR)
  file(STRINGS "${Gpiod_INCLUDE_DIR}/gpiod.h" _requests REGEX "gpiod_chip_request_lines")
  set(Gpiod_API 1)
  if(_requests)
    set(Gpiod_API 2)
  endif()
  unset(_requests)
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Gpiod REQUIRED_VARS Gpiod_LIBRARY Gpiod_INCLUDE_DIR)

if(Gpiod_FOUND AND NOT TARGET Gpiod::gpiod)
  add_library(Gpiod::gpiod UNKNOWN IMPORTED)
  set_target_properties(Gpiod::gpiod PROPERTIES
    IMPORTED_LOCATION "${Gpiod_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Gpiod_INCLUDE_DIR}")
endif()
