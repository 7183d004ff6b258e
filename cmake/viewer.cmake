# The pages of `lightcook view` and of reports: bundled by Node, then written as C++ (pipeline/report/bundle.h).
set(viewer_bundle ${PROJECT_BINARY_DIR}/generated/viewer_bundle.cpp)
set(viewer ${PROJECT_SOURCE_DIR}/viewer)
if(LIGHTCOOK_VIEWER)
  find_program(NODE node REQUIRED)
  if(NOT EXISTS ${viewer}/node_modules)
    message(FATAL_ERROR "viewer/node_modules is missing: run ./dev setup build, or configure with -DLIGHTCOOK_VIEWER=OFF")
  endif()
  file(GLOB_RECURSE viewer_sources CONFIGURE_DEPENDS ${viewer}/src/* ${viewer}/report/* ${viewer}/loaders/*.js)
  add_custom_command(
    OUTPUT ${viewer_bundle}
    COMMAND ${NODE} ${viewer}/build.mjs ${PROJECT_BINARY_DIR}/viewer
    COMMAND ${NODE} ${viewer}/embed.mjs ${PROJECT_BINARY_DIR}/viewer ${viewer_bundle}
    DEPENDS ${viewer_sources} ${viewer}/build.mjs ${viewer}/embed.mjs ${viewer}/package-lock.json
    COMMENT "Bundling the pages"
    VERBATIM)
else()
  file(CONFIGURE OUTPUT ${viewer_bundle} @ONLY CONTENT [[
#include "pipeline/report/bundle.h"

namespace lightcook::pipeline {

std::span<const BundledFile> viewerBundle() {
    return {};
}

std::string_view reportTemplate() {
    return R"(<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title><!--title--></title></head>
<body><main><!--table--></main><script type="application/json" id="data"><!--data--></script></body>
</html>
)";
}

}  // namespace lightcook::pipeline
]])
endif()
