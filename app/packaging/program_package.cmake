# The package facet: the program, its service and what facet report runs.
set(CPACK_PACKAGE_NAME facet)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "stereo visual-inertial estimator")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
"Estimates pose, velocity and sensor biases of a vehicle from stereo images and
an inertial sensor, on one core; builds a mesh of what it sees and finds floors
and walls in it.
.
Installs a systemd service that runs as the user facet, without root, and is
not started before its configuration has been written.")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "${_libraries}, ${_gpiod}, adduser")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "udev")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "python3, python3-numpy, python3-pil, python3-matplotlib")
file(WRITE "${_made}/conffiles" "/etc/facet/vehicle.yaml\n")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
  "${_made}/conffiles"
  "${CMAKE_CURRENT_SOURCE_DIR}/postinst"
  "${CMAKE_CURRENT_SOURCE_DIR}/prerm"
  "${CMAKE_CURRENT_SOURCE_DIR}/postrm")
set(CPACK_INSTALL_CMAKE_PROJECTS "${CMAKE_BINARY_DIR};facet;program;/") # build folder, project, component, below
