// Digests that parts of the cook and of the verification of a light map are named by (PartCache).
#pragma once

#include <string>

#include "formats/archive.h"
#include "formats/light_map.h"
#include "pipeline/graph/digest.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

/// Returns the digest of some values. They have no bytes that are not theirs: no padding.
template <class... T>
std::string digestOf(const T&... values) {
    formats::ArchiveWriter writer;
    writer(values...);
    return digestOfText(writer.take());
}

/// Return a digest of all texels, and of where they lie.
std::string digestOfStrip(const formats::LightMapStrip& strip);
std::string digestOfRows(const verify::DecodedLightMapRows& rows);

}  // namespace lightcook::pipeline
