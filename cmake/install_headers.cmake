# Installs the root headers of the modules, every header of ours that one of them includes, and the shader sources that are C++ too. Their
# includes get the folder that users name: "compress/encode.h" becomes "lightcook/compress/encode.h". Runs during `cmake --install`.
# source       the source tree
# modules      the modules whose root headers are public
# rewritten    a folder of the build for the headers
# destination  the folder that they are installed into
cmake_policy(VERSION 3.25)
set(waiting)
foreach(module ${modules})
  file(GLOB headers RELATIVE ${source} ${source}/${module}/*.h)
  list(APPEND waiting ${headers})
endforeach()
set(found)
while(waiting)
  list(POP_FRONT waiting header)
  if(header IN_LIST found OR NOT EXISTS ${source}/${header})
    continue()
  endif()
  list(APPEND found ${header})
  file(STRINGS ${source}/${header} includes REGEX "^#include \"[^\"]+\"")
  foreach(line ${includes})
    string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" name "${line}")
    list(APPEND waiting ${name})
  endforeach()
endwhile()
foreach(header ${found})
  file(READ ${source}/${header} text)
  string(REGEX REPLACE "(^|\n)#include \"" "\\1#include \"lightcook/" text "${text}")
  file(WRITE ${rewritten}/${header} "${text}")
  get_filename_component(folder ${header} DIRECTORY)
  file(INSTALL ${rewritten}/${header} DESTINATION ${destination}/${folder})
endforeach()
