# The package python3-facet: the Python module, its types and the demo. It needs no other package of ours.
set(CPACK_PACKAGE_NAME python3-facet)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "stereo visual-inertial estimator (Python module)")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
"Estimates pose, velocity and sensor biases of a vehicle from stereo images and
an inertial sensor, given as arrays of numpy; builds a mesh of what it sees and
finds floors and walls in it; reads logs, simulates flights and evaluates
estimates.")
set(CPACK_DEBIAN_PACKAGE_SECTION python)
# The module is for one minor version of Python: that which it was compiled with.
execute_process(COMMAND "${FACET_PYTHON_PROGRAM}" -c
    "import sys; a, b = sys.version_info[:2]; print(f'python3 (>= {a}.{b}), python3 (<< {a}.{b + 1})', end='')"
  OUTPUT_VARIABLE _python COMMAND_ERROR_IS_FATAL ANY)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "${_libraries}, ${_python}, python3-numpy")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
  "${CMAKE_CURRENT_SOURCE_DIR}/python/postinst"
  "${CMAKE_CURRENT_SOURCE_DIR}/python/prerm")
set(CPACK_INSTALL_CMAKE_PROJECTS "${CMAKE_BINARY_DIR};facet;python;/") # build folder, project, component, below
