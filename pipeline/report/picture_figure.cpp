#include "pipeline/report/picture_figure.h"

#include <algorithm>

#include "pipeline/report/page_parts.h"

namespace lightcook::pipeline {

Html pictureFigure(const StagedFolder& folder, const std::string& file, const std::string& alt, const Html& caption, bool isLight) {
    constexpr std::uint32_t kSmoothFrom = 256;  // [pixels] smaller pictures are enlarged without smoothing, so that texels can be seen
    const auto picture = loadPicture(folder.of(file), file);
    Html content;
    if (picture) {
        const char* scaling = std::max(picture->width, picture->height) < kSmoothFrom ? "pixels" : "smooth";
        content = voidElement("img", {{"src", picture->dataUri},
                                      {"alt", alt},
                                      {"class", std::string(scaling) + (isLight ? " light" : "")},
                                      {"width", std::to_string(picture->width)},
                                      {"height", std::to_string(picture->height)}});
    } else {
        content = element("div", {{"class", "missing"}}, text(file.empty() ? "no picture" : "picture missing: " + file));
    }
    return element("figure", content + element("figcaption", caption));
}

}  // namespace lightcook::pipeline
