// Digests that parts of the cook and of the verification of a light map are named by (PartCache).
#pragma once

#include <span>
#include <string>

#include "formats/archive.h"
#include "formats/light_map.h"
#include "pipeline/graph/digest.h"

namespace lightcook::pipeline {

/// Returns the digest of some values. They have no bytes that are not theirs: no padding.
template <class... T>
std::string digestOf(const T&... values) {
    formats::ArchiveWriter writer;
    writer(values...);
    return digestOfText(writer.take());
}

/// Returns the digest of row y of a strip, from its first row on.
std::string digestOfRow(const formats::LightMapStrip& strip, int y);

template <class T>
std::string digestOfImage(const formats::Image<T>& image) {
    const auto bytes = std::as_bytes(std::span(image.texels()));
    return digestOf(image.width(), digestOfText({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
}

}  // namespace lightcook::pipeline
