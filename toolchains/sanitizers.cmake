# FACET_SANITIZE: a comma-separated list for -fsanitize, empty for none. Any finding ends the program.
set(FACET_SANITIZE "" CACHE STRING "Sanitizers of the whole build, e.g. address,undefined or thread")
if(FACET_SANITIZE)
  string(APPEND CMAKE_CXX_FLAGS " -fsanitize=${FACET_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer")
endif()
