// The decoders of lightcook-read, by ForeignKind.
#pragma once

#include <memory>

#include "formats/reader/reader_server.h"

namespace lightcook::formats {

std::unique_ptr<ForeignDecoder> decodeExrBehindWall(const ForeignInput& input);
std::unique_ptr<ForeignDecoder> decodeImageBehindWall(const ForeignInput& input);
std::unique_ptr<ForeignDecoder> decodeDracoBehindWall(const ForeignInput& input);
std::unique_ptr<ForeignDecoder> measureDracoBehindWall(const ForeignInput& input);

}  // namespace lightcook::formats
