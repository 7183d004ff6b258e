#include "pipeline/assets/light_map/strip_digest.h"

#include "formats/digest.h"

namespace lightcook::pipeline {

std::string digestOfRow(const formats::LightMapStrip& strip, int y) {
    formats::Digest digest;
    const auto add = [&](const auto& image) {
        if (image.width() > 0) digest.add(std::span(image.view().row(y), static_cast<std::size_t>(image.width())));
    };
    add(strip.sh);
    add(strip.covered);
    add(strip.normal);
    add(strip.tangent);
    add(strip.chart);
    return digest.text();
}

}  // namespace lightcook::pipeline
