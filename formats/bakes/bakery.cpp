#include "formats/bakes/bakery.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "formats/bakes/direction_map.h"
#include "formats/bakes/exit_radiance.h"
#include "formats/bakes/file_set.h"
#include "formats/bakes/images_reader.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;

/// The coefficient that each file becomes.
constexpr std::array<std::size_t, 4> kCoefficients = {0, 3, 1, 2};

class BakeryReader final : public ImagesReader {
public:
    BakeryReader(std::vector<BakeImage> images, SurfaceChannels surface) : ImagesReader(std::move(images), std::move(surface)) {}

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw = emptyStrip(rowCount);
        for (std::size_t image = 0; image < images().size(); ++image) {
            std::vector<ExrPlane> planes;
            if (image == 0) addSurface(raw, planes);
            addColours(raw, kCoefficients.at(image), planes);
            LC_CHECK(images()[image].readRows(firstRow, rowCount, planes));
        }
        for (ShRgb& sh : raw.sh.texels()) {
            for (std::size_t i = 1; i < kBakeryEndings.size(); ++i) sh[i] = kLinearOfExit * 4 * sh[0] * (sh[i] - 0.5f);
            sh[0] *= kFirstOfExit;
        }
        return raw;
    }

private:
    ChannelOfImage sourceOf(std::size_t coefficient, int colour) const override {
        const auto found = std::ranges::find(kCoefficients, coefficient);
        return {found == kCoefficients.end() ? 0 : static_cast<std::size_t>(found - kCoefficients.begin()), colourName(colour)};
    }
};

/// L1 = 4 L0 (t - 0.5).
std::optional<DirectedResponse> monoResponse(const glm::vec4& stored) {
    return DirectedResponse{1, 4.0f * (glm::vec3(stored) - 0.5f)};
}

bool isComplete(const std::vector<std::filesystem::path>& files) {
    const auto exists = [](const std::filesystem::path& file) {
        std::error_code code;
        return std::filesystem::exists(file, code);
    };
    return !files.empty() && std::ranges::all_of(files, exists);
}

/// Matches a file with the set of some endings. Beside a complete set of `others`, which has the same first file, neither is certain.
BakeMatch matchSet(const std::filesystem::path& file, const ExrInfo& info, std::span<const std::string_view> endings,
                   std::span<const std::string_view> others, std::string_view format) {
    const auto files = filesOfMixedSet(file, endings);
    if (files.empty() || !isPicture(info)) return {};
    BakeMatch match = matchFiles(file, files, 3 * static_cast<int>(endings.size()), format, FileKinds::Mixed);
    if (match.kind == BakeMatch::Kind::Certain && isComplete(filesOfMixedSet(file, others))) match.kind = BakeMatch::Kind::Possible;
    return match;
}

}  // namespace

BakeMatch matchBakerySh(const std::filesystem::path& file, const ExrInfo& info) {
    return matchSet(file, info, kBakeryEndings, kMonoEndings, "bakery-sh");
}

BakeMatch matchBakeryMonoSh(const std::filesystem::path& file, const ExrInfo& info) {
    return matchSet(file, info, kMonoEndings, kBakeryEndings, "bakery-mono-sh");
}

std::vector<std::filesystem::path> filesBesideBakerySh(const std::filesystem::path& file) {
    return filesOfMixedSet(file, kBakeryEndings);
}

std::vector<std::filesystem::path> filesBesideBakeryMonoSh(const std::filesystem::path& file) {
    return filesOfMixedSet(file, kMonoEndings);
}

Result<std::unique_ptr<BakeReader>> openBakerySh(BakeImage image) {
    const auto files = filesOfMixedSet(image.file(), kBakeryEndings);
    Result<std::vector<BakeImage>> images = openImages(std::move(image), files);
    if (!images) return tl::make_unexpected(images.error());
    Result<SurfaceChannels> surface = SurfaceChannels::of(images->front(), "A");
    if (!surface) return tl::make_unexpected(surface.error());
    return std::make_unique<BakeryReader>(std::move(*images), std::move(*surface));
}

Result<std::unique_ptr<BakeReader>> openBakeryMonoSh(BakeImage image) {
    const auto files = filesOfMixedSet(image.file(), kMonoEndings);
    Result<std::vector<BakeImage>> images = openImages(std::move(image), files);
    if (!images) return tl::make_unexpected(images.error());
    return openDirectionMap(std::move(*images), {.response = monoResponse, .needsAlpha = false, .expected = ""});
}

}  // namespace lightcook::formats
