#include "formats/bakes/deluxe.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "formats/bakes/exit_radiance.h"
#include "formats/bakes/file_set.h"
#include "formats/bakes/on_surface.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;

constexpr float kLeastCosine = 0.25f, kShortest = 0.125f;
/// Share of the light that renderer 2 of ioquake3 takes for light from one direction (code/renderergl2/glsl/lightall_fp.glsl). It reserves
/// the rest as even light, so that no normal of a normal map is black.
constexpr float kDirected = 0.75f;
/// Coefficients to whose red the direction is read.
constexpr std::size_t kDirection = 1;

/// Returns what nine coefficients of a light of strength 1 show where the normal has this cosine to it: 1/4 + x/2 + 5/16 P_2(x).
float shownAt(float cosine) {
    return 0.25f + 0.5f * cosine + 0.15625f * (3 * cosine * cosine - 1);
}

/// Returns the pages n and n + 1, n even, of a name that ends in a number of at least two digits; else nothing.
std::vector<std::filesystem::path> pagesOf(const std::filesystem::path& file) {
    const std::string stem = file.stem().string();
    const std::size_t first = stem.find_last_not_of("0123456789") + 1, digits = stem.size() - first;
    constexpr std::size_t kFewest = 2, kMost = 9;
    if (digits < kFewest || digits > kMost) return {};
    int page = 0;
    std::from_chars(stem.data() + first, stem.data() + stem.size(), page);
    std::vector<std::filesystem::path> files;
    for (const int number : {page / 2 * 2, page / 2 * 2 + 1})
        files.push_back(file.parent_path() / fmt::format("{}{:0{}}{}", stem.substr(0, first), number, digits, file.extension().string()));
    return files;
}

std::vector<std::filesystem::path> pairOf(const std::filesystem::path& file) {
    if (endsInAnyCase(file.stem().string(), kDeluxeEndings[1])) return filesOfMixedSet(file, kDeluxeEndings);
    auto files = filesOfMixedSet(file, std::span(kDeluxeEndings).first(1));
    std::filesystem::path directions =
        file.parent_path() / (file.stem().string() + std::string(kDeluxeEndings[1]) + file.extension().string());
    files.push_back(filesOfMixedSet(directions, std::span(kDeluxeEndings).last(1)).front());
    return files;
}

class DeluxeReader final : public OnSurfaceReader {
public:
    DeluxeReader(std::vector<BakeImage> images, SurfaceChannels surface, SurfaceFrames frames)
        : OnSurfaceReader(std::move(images), std::move(surface), std::move(frames)) {}

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw = emptyStrip(rowCount);
        std::vector<ExrPlane> colours, directions;
        addSurface(raw, colours);
        addColours(raw, 0, colours);
        addColours(raw, kDirection, directions);
        LC_CHECK(images()[0].readRows(firstRow, rowCount, colours));
        LC_CHECK(images()[1].readRows(firstRow, rowCount, directions));
        const Image<SurfaceFrame> frames = putOnSurface(raw, firstRow);
        for (int y = 0; y < rowCount; ++y)
            for (int x = 0; x < width(); ++x) raw.sh.at(x, y) = decoded(raw.sh.at(x, y), frames.at(x, y).normal);
        return raw;
    }

private:
    static ShRgb decoded(const ShRgb& stored, const glm::vec3& normal) {
        const glm::vec3 colour = stored[0], direction = 2.0f * stored[kDirection] - 1.0f;
        const float length = glm::length(direction);
        ShRgb sh{};
        if (normal == glm::vec3(0)) return sh;
        float light = 0, everywhere = 1;  // strengths over the colour
        if (!(length < kShortest)) {      // NaN goes on, and is refused by texel
            const float cosine = glm::dot(normal, direction / length), facing = std::max(cosine, 0.0f);
            light = facing >= kLeastCosine ? kDirected / shownAt(cosine) : kDirected / kLeastCosine;
            everywhere = facing >= kLeastCosine ? 1 - kDirected : 1 - light * shownAt(cosine);
            sh = lighting::projectDirectional(direction / length, std::numbers::pi_v<float> * light * colour);
        }
        sh[0] += kFirstOfExit * everywhere * colour;
        return sh;
    }
};

}  // namespace

std::vector<std::filesystem::path> filesBesideDeluxe(const std::filesystem::path& file) {
    auto pair = pairOf(file);
    std::error_code code;
    if (std::filesystem::exists(pair[1], code) || file == pair[1]) return pair;
    return pagesOf(file);
}

BakeMatch matchDeluxe(const std::filesystem::path& file, const ExrInfo& info) {
    constexpr int kNumbers = 6;
    if (!isPicture(info)) return {};
    const auto files = filesBesideDeluxe(file);
    const bool isPair = files.empty() || endsInAnyCase(files[1].stem().string(), kDeluxeEndings[1]);
    BakeMatch match =
        matchFiles(file, files.empty() ? pairOf(file) : files, kNumbers, "deluxe", isPair ? FileKinds::Mixed : FileKinds::Same);
    // Every picture may lack directions: only the scene file can say that they are missing.
    if (files.empty()) match.kind = BakeMatch::Kind::None;
    if (!isPair) match.kind = match.kind == BakeMatch::Kind::Certain ? BakeMatch::Kind::OnlyNamed : BakeMatch::Kind::None;
    return match;
}

Result<std::unique_ptr<BakeReader>> openDeluxe(BakeImage image, const BakeSurface& surface) {
    const auto files = filesBesideDeluxe(image.file());
    return openOnSurface<DeluxeReader>(std::move(image), files, surface);
}

}  // namespace lightcook::formats
