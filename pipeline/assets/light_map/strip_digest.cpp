#include "pipeline/assets/light_map/strip_digest.h"

#include <span>
#include <vector>

namespace lightcook::pipeline {

namespace {

template <class T>
std::string digestOfImage(const formats::Image<T>& image) {
    const auto bytes = std::as_bytes(std::span(image.texels()));
    return digestOfText({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::string digestOfLayers(const std::vector<std::vector<formats::Image<glm::vec4>>>& textures) {
    std::vector<std::vector<std::string>> digests;
    for (const auto& layers : textures) {
        std::vector<std::string>& ofLayers = digests.emplace_back();
        for (const auto& layer : layers) ofLayers.push_back(digestOfImage(layer));
    }
    return digestOf(digests);
}

}  // namespace

std::string digestOfStrip(const formats::LightMapStrip& strip) {
    return digestOf(strip.firstRow, digestOfImage(strip.sh), digestOfImage(strip.covered), digestOfImage(strip.normal),
                    digestOfImage(strip.tangent), digestOfImage(strip.chart));
}

std::string digestOfRows(const verify::DecodedLightMapRows& rows) {
    return digestOf(rows.firstRow, digestOfLayers(rows.textures), digestOfLayers(rows.spans), digestOfImage(rows.covered),
                    digestOfImage(rows.detail.has), digestOfLayers(rows.detail.textures));
}

}  // namespace lightcook::pipeline
