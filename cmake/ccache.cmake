# Compiles through ccache where it is installed, unless CMAKE_CXX_COMPILER_LAUNCHER says otherwise.
# Sloppiness: without it ccache refuses whatever uses a precompiled header.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE_PROGRAM})
endif()
