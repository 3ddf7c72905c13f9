# FACET_SANITIZE: a comma-separated list for -fsanitize, empty for none. Any finding ends the program.
set(FACET_SANITIZE "" CACHE STRING "Sanitizers of the whole build, e.g. address,undefined or thread")
if(FACET_SANITIZE)
  add_compile_options(-fsanitize=${FACET_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${FACET_SANITIZE})
endif()
