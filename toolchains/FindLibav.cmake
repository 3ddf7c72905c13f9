# FFmpeg's libavformat, libavcodec and libavutil as Libav::libav.
find_path(Libav_INCLUDE_DIR libavformat/avformat.h PATH_SUFFIXES ffmpeg)
find_library(Libav_format_LIBRARY avformat)
find_library(Libav_codec_LIBRARY avcodec)
find_library(Libav_util_LIBRARY avutil)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Libav
  REQUIRED_VARS Libav_format_LIBRARY Libav_codec_LIBRARY Libav_util_LIBRARY Libav_INCLUDE_DIR)

if(Libav_FOUND AND NOT TARGET Libav::libav)
  add_library(Libav::libav INTERFACE IMPORTED GLOBAL)
  target_include_directories(Libav::libav SYSTEM INTERFACE "${Libav_INCLUDE_DIR}")
  target_link_libraries(Libav::libav
    INTERFACE "${Libav_format_LIBRARY}" "${Libav_codec_LIBRARY}" "${Libav_util_LIBRARY}")
endif()
