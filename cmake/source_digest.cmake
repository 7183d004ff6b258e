# Writes a header with a digest of every source of the library: the tool's own part in the key of a cached action.
# cmake -DSOURCES="a;b" -DOUT=header -P source_digest.cmake
set(all "")
foreach(source IN LISTS SOURCES)
  file(SHA256 ${source} digest)
  string(APPEND all "${digest}")
endforeach()
string(SHA256 digest "${all}")
file(WRITE ${OUT}.new "#pragma once\n\nnamespace lightcook::pipeline {\n\n/// Changes with every source of lightcook.\ninline constexpr const char* kSourceDigest = \"${digest}\";\n\n}  // namespace lightcook::pipeline\n")
file(COPY_FILE ${OUT}.new ${OUT} ONLY_IF_DIFFERENT)
