# Cyclone DDS as CycloneDDS::ddsc, and its compiler of IDL files as CycloneDDS::idlc: Debian ships no CMake package.
find_path(CycloneDDS_INCLUDE_DIR dds/dds.h)
find_library(CycloneDDS_LIBRARY ddsc)
find_program(CycloneDDS_IDLC idlc)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(CycloneDDS
  REQUIRED_VARS CycloneDDS_LIBRARY CycloneDDS_INCLUDE_DIR CycloneDDS_IDLC)

if(CycloneDDS_FOUND AND NOT TARGET CycloneDDS::ddsc)
  add_library(CycloneDDS::ddsc UNKNOWN IMPORTED)
  set_target_properties(CycloneDDS::ddsc PROPERTIES
    IMPORTED_LOCATION "${CycloneDDS_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${CycloneDDS_INCLUDE_DIR}")
  add_executable(CycloneDDS::idlc IMPORTED)
  set_target_properties(CycloneDDS::idlc PROPERTIES IMPORTED_LOCATION "${CycloneDDS_IDLC}")
endif()
