#include "formats/bakes/unity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "formats/bakes/direction_map.h"
#include "formats/bakes/file_set.h"

namespace lightcook::formats {
namespace {

constexpr float kSmallestWeight = 1e-4f, kLongest = 0.75f;

std::optional<DirectedResponse> responseOf(const glm::vec4& stored) {
    if (!std::isfinite(stored.w)) return DirectedResponse{stored.w, glm::vec3(stored.w)};  // refused by texel
    const glm::vec3 direction = glm::vec3(stored) - 0.5f;
    if (stored.w <= 0 || glm::length(direction) > kLongest) return std::nullopt;
    const float weight = std::max(stored.w, kSmallestWeight);
    return DirectedResponse{0.5f / weight, direction / weight};
}

BakeMatch matchPair(const std::filesystem::path& file, const ExrInfo& info, std::span<const std::string_view> endings,
                    std::string_view format) {
    constexpr int kNumbers = 7;
    const auto files = filesOfMixedSet(file, endings);
    if (files.empty() || !isPicture(info)) return {};
    return matchWithDirections(file, files, kNumbers, format);
}

Result<std::unique_ptr<BakeReader>> openPair(BakeImage image, std::span<const std::string_view> endings, bool needsAlpha) {
    const auto files = filesOfMixedSet(image.file(), endings);
    Result<std::vector<BakeImage>> images = openImages(std::move(image), files);
    if (!images) return tl::make_unexpected(images.error());
    const bool hasAlpha = (*images)[1].info().has("A");
    return openDirectionMap(std::move(*images), {.response = responseOf,
                                                 .needsAlpha = needsAlpha || hasAlpha,
                                                 .expected = "a direction within 0.75 of (0.5, 0.5, 0.5), and an alpha above 0"});
}

}  // namespace

BakeMatch matchUnityDirectional(const std::filesystem::path& file, const ExrInfo& info) {
    return matchPair(file, info, kUnityEndings, "unity-directional");
}

BakeMatch matchBakeryDominant(const std::filesystem::path& file, const ExrInfo& info) {
    return matchPair(file, info, kDominantEndings, "bakery-dominant");
}

std::vector<std::filesystem::path> filesBesideUnityDirectional(const std::filesystem::path& file) {
    return filesOfMixedSet(file, kUnityEndings);
}

std::vector<std::filesystem::path> filesBesideBakeryDominant(const std::filesystem::path& file) {
    return filesOfMixedSet(file, kDominantEndings);
}

Result<std::unique_ptr<BakeReader>> openUnityDirectional(BakeImage image) {
    return openPair(std::move(image), kUnityEndings, true);
}

Result<std::unique_ptr<BakeReader>> openBakeryDominant(BakeImage image) {
    return openPair(std::move(image), kDominantEndings, false);
}

}  // namespace lightcook::formats
