#include "pipeline/assets/preview.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>

#include "formats/png.h"
#include "lighting/radiometry.h"
#include "pipeline/graph/files.h"

namespace lightcook::pipeline {
namespace {

/// The largest errors that the heat scale tells apart, shown white: a local relative error of 10 %, and 10 just noticeable differences.
constexpr float kLocalScale = 0.1f, kVisibleScale = 10;

/// Black, violet, red, orange, yellow, white: growing luminance, so that it reads in grey as well.
constexpr std::array<std::array<double, 3>, 6> kHeatRamp = {
    {{0, 0, 0}, {70, 15, 110}, {190, 40, 75}, {240, 110, 30}, {250, 205, 60}, {255, 255, 255}}};

/// part  of the scale
glm::u8vec3 heat(float part) {
    const double place = std::min(static_cast<double>(part), 1.0) * (kHeatRamp.size() - 1);
    const std::size_t low = std::min(static_cast<std::size_t>(place), kHeatRamp.size() - 2);
    const double fraction = place - static_cast<double>(low);
    glm::u8vec3 pixel(0);
    for (int channel = 0; channel < 3; ++channel) {
        const std::size_t c = static_cast<std::size_t>(channel);
        pixel[channel] = static_cast<std::uint8_t>(std::lround((1 - fraction) * kHeatRamp[low][c] + fraction * kHeatRamp[low + 1][c]));
    }
    return pixel;
}

}  // namespace

glm::u8vec3 toneMapped(const glm::vec3& radiance, double key) {
    glm::u8vec3 pixel(0);
    for (int channel = 0; channel < 3; ++channel) {
        const double exposed = key > 0 ? std::max(0.0, 0.7 * static_cast<double>(radiance[channel]) / key) : 0.0;
        pixel[channel] = static_cast<std::uint8_t>(std::lround(255 * std::pow(exposed / (1 + exposed), 1 / 2.2)));
    }
    return pixel;
}

glm::u8vec3 heatOf(float visible) {
    return heat(visible / kVisibleScale);
}

Preview::Preview(int width, int height, double key, int firstRow, int rowCount)
    : key_(key),
      stride_(std::max(1, (std::max(width, height) + kLongestSide - 1) / kLongestSide)),
      firstRow_(firstRow),
      rowCount_(rowCount),
      firstPixelRow_(firstRow / stride_) {
    const int across = (width + stride_ - 1) / stride_, down = (firstRow + rowCount + stride_ - 1) / stride_ - firstPixelRow_;
    reference_ = formats::Image<glm::u8vec3>(across, down);
    cooked_ = formats::Image<glm::u8vec3>(across, down);
    worst_ = formats::Image<float>(across, down);
    anyNormal_ = formats::Image<float>(across, down, -1);
}

void Preview::merge(const Preview& rows) {
    for (int row = 0; row < rows.worst_.height(); ++row) {
        const int y = rows.firstPixelRow_ + row, texelRow = y * stride_;
        const bool isShown = rows.firstRow_ <= texelRow && texelRow < rows.firstRow_ + rows.rowCount_;
        for (int x = 0; x < worst_.width(); ++x) {
            worst_.at(x, y) = std::max(worst_.at(x, y), rows.worst_.at(x, row));
            if (!isShown) continue;
            reference_.at(x, y) = rows.reference_.at(x, row);
            cooked_.at(x, y) = rows.cooked_.at(x, row);
            anyNormal_.at(x, y) = rows.anyNormal_.at(x, row);
        }
    }
}

float Preview::localError(const glm::vec3& reference, const glm::vec3& cooked) const {
    float worst = 0;
    for (int channel = 0; channel < 3; ++channel) {
        const float allowed = std::abs(reference[channel]) + static_cast<float>(lighting::kLocalErrorFloor * key_);
        worst = std::max(worst, allowed > 0 ? std::abs(cooked[channel] - reference[channel]) / allowed : 0.0f);
    }
    return worst;
}

void Preview::show(int x, int y, const glm::vec3& reference, const glm::vec3& cooked, float part) {
    // Threads may share a pixel. The largest of them all is the same in any order.
    const std::atomic_ref<float> pixel(worst_.at(x / stride_, y / stride_ - firstPixelRow_));
    for (float seen = pixel.load(); part > seen && !pixel.compare_exchange_weak(seen, part);) {
    }
    if (!shows(x, y)) return;
    reference_.at(x / stride_, y / stride_ - firstPixelRow_) = toneMapped(reference, key_);
    cooked_.at(x / stride_, y / stride_ - firstPixelRow_) = toneMapped(cooked, key_);
}

void Preview::set(int x, int y, const glm::vec3& reference, const glm::vec3& cooked) {
    show(x, y, reference, cooked, localError(reference, cooked) / kLocalScale);
}

void Preview::set(int x, int y, const glm::vec3& reference, const glm::vec3& cooked, float visible) {
    show(x, y, reference, cooked, visible / kVisibleScale);
}

void Preview::setAtAnyNormal(int x, int y, float visible) {
    if (shows(x, y)) anyNormal_.at(x / stride_, y / stride_ - firstPixelRow_) = visible;
}

formats::Result<PreviewFiles> Preview::write(const std::filesystem::path& folder, const std::string& name) const {
    formats::Image<glm::u8vec3> difference(worst_.width(), worst_.height());
    std::ranges::transform(worst_.texels(), difference.texels().begin(), heat);
    const auto writePng = [&](const char* suffix, const formats::Image<glm::u8vec3>& picture) -> formats::Result<std::string> {
        std::string file = "preview/" + name + "_" + suffix + ".png";
        LC_TRY(png, formats::encodePng(picture.view()));
        LC_CHECK(writeFile(folder / file, *png));
        return file;
    };
    const auto reference = writePng("reference", reference_), cooked = writePng("cooked", cooked_),
               worst = writePng("difference", difference);
    for (const auto* file : {&reference, &cooked, &worst})
        if (!*file) return tl::make_unexpected(file->error());
    PreviewFiles files{*reference, *cooked, *worst};
    if (std::ranges::all_of(anyNormal_.texels(), [](float visible) { return visible < 0; })) return files;
    std::ranges::transform(anyNormal_.texels(), difference.texels().begin(), [](float visible) { return heatOf(std::max(visible, 0.0f)); });
    LC_TRY(anyNormal, writePng("any_normal", difference));
    files.anyNormal = std::move(*anyNormal);
    return files;
}

formats::Result<ActionOutcome> outcomeWithPreview(VerifyResult result, const Preview& preview, const ActionContext& context,
                                                  std::vector<WorstPlacePicture> worst, std::vector<RenderedView> seams) {
    LC_TRY(files, preview.write(context.folder, context.action.asset));
    files->worst = std::move(worst);
    files->seams = std::move(seams);
    result.preview = std::move(*files);
    return outcomeWith(result, result.preview->all());
}

}  // namespace lightcook::pipeline
