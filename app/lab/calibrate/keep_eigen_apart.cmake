# cmake -DARCHIVE=FILE -DOUT=FILE -DNM=nm -DOBJCOPY=objcopy -P keep_eigen_apart.cmake
# Copies a static library, with another name for every function of Eigen that is compiled into it.
execute_process(COMMAND "${NM}" --defined-only --format=posix "${ARCHIVE}"
  OUTPUT_VARIABLE symbols ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "(^|\n)_Z(Z|GVZ)?NK?5Eigen[^ \n]* [WVu] " symbols "${symbols}")
list(TRANSFORM symbols REPLACE "[\n]|( [WVu] )" "")
list(REMOVE_DUPLICATES symbols)
list(TRANSFORM symbols REPLACE "(.+)" "\\1 apart\\1\n")
list(JOIN symbols "" map)
file(WRITE "${OUT}.map" "${map}")
execute_process(COMMAND "${OBJCOPY}" "--redefine-syms=${OUT}.map" "${ARCHIVE}" "${OUT}" COMMAND_ERROR_IS_FATAL ANY)
