# Run at build time (cmake -DSOURCE=... -DOUTPUT=... -P): writes a source file that holds the commit of the tree SOURCE,
# and touches it only if that has changed. "+changes": tracked files differ from the commit. "unknown": not a git
# checkout. FACET_COMMIT in the environment takes precedence, for builds from an archive.
set(_commit "$ENV{FACET_COMMIT}")
if(NOT _commit)
  set(_commit "unknown")
  find_program(GIT git)
  if(GIT)
    execute_process(COMMAND "${GIT}" -C "${SOURCE}" rev-parse --short=12 HEAD
      OUTPUT_VARIABLE _head RESULT_VARIABLE _failed OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(NOT _failed)
      set(_commit "${_head}")
      execute_process(COMMAND "${GIT}" -C "${SOURCE}" diff --quiet HEAD -- RESULT_VARIABLE _changed ERROR_QUIET)
      if(_changed)
        string(APPEND _commit "+changes")
      endif()
    endif()
  endif()
endif()
if(NOT _commit MATCHES "^[A-Za-z0-9._+-]+$")
  message(FATAL_ERROR "FACET_COMMIT: '${_commit}' is no name of a commit")
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" @ONLY CONTENT [[
// Written by toolchains/source_commit.cmake.
#include "app/commands/build_version.h"

namespace facet {

const char* build_commit() { return "@_commit@"; }

}  // namespace facet
]])
