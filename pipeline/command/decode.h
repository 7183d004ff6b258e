// lightcook decode: a texture as a float EXR.
#pragma once

#include <filesystem>

#include "formats/error.h"
#include "pipeline/document/json.h"

namespace lightcook::pipeline {

struct DecodeCommand {
    std::filesystem::path input, output;
    int mip = 0, layer = 0;
};

/// Writes a float EXR with the format's channels, texels as they are stored; a cubemap as a vertical strip of its faces. Returns
/// {"width","height","channels","mip","layer"} and, of a cooked texture, "constants" that its shader makes light of the texels with.
formats::Result<Json> decodeTexture(const DecodeCommand& command);

}  // namespace lightcook::pipeline
