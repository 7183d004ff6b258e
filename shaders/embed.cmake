# Writes sources.cpp, which defines shaders::allSources() from the text of the .glsl files:
#   cmake -DOUTPUT=sources.cpp -DSOURCES=a.glsl,b.glsl -P embed.cmake
string(REPLACE "," ";" files "${SOURCES}")
set(text "// Written by shaders/embed.cmake from the .glsl files.\n#include \"shaders/include.h\"\n\nnamespace lightcook::shaders {\n\n")
string(APPEND text "std::span<const ShaderSource> allSources() {\n    static constexpr ShaderSource kSources[] = {\n")
foreach(file IN LISTS files)
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" content)
  string(APPEND text "        {\"${name}\", R\"lightcook(${content})lightcook\"},\n")
endforeach()
string(APPEND text "    };\n    return kSources;\n}\n\n}  // namespace lightcook::shaders\n")
file(WRITE "${OUTPUT}" "${text}")
