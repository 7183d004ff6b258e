// Verification of what the converters made: cubemaps, Cook-Torrance tables, dominant lights. Each reads the files that the
// cook left and the source itself; pieces of work are spread over the threads and put together in one order.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <optional>

#include "fit/specular_tables.h"
#include "lighting/cube.h"
#include "lighting/sphere.h"
#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/light_map/ground_truth.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/lut/light_moments.h"
#include "pipeline/assets/preview.h"
#include "pipeline/assets/textures.h"
#include "pipeline/assets/verdict.h"
#include "pipeline/assets/verification.h"
#include "pipeline/graph/parallel_for.h"
#include "shaders/lightcook_cpp.h"
#include "verify/block_errors.h"
#include "verify/cubemap.h"
#include "verify/dominant.h"
#include "verify/lut.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Image;
using formats::LightMapStrip;
using formats::Result;

/// What the tables are shaded with: both ends of Fresnel's range, a dielectric and a metal.
const std::vector<double> kTableF0 = {0.0, 0.04, 0.6, 1.0};
constexpr int kRandomTableSamples = 800;
/// Half a step of rounding, and the fetch in single precision.
constexpr double kTableSteps = 0.75;

glm::vec4 vec4From(const Json& json) {
    return {json.at(0).get<float>(), json.at(1).get<float>(), json.at(2).get<float>(), json.at(3).get<float>()};
}
glm::vec3 vec3From(const Json& json) {
    return {json.at(0).get<float>(), json.at(1).get<float>(), json.at(2).get<float>()};
}

Result<verify::CookedCubemap> readCubemap(const ActionContext& context, const Json& asset) {
    const Json& constants = asset.at("constants");
    const auto texture = openTexture(context.upstreamFolder, asset, "cubemap");
    if (!texture) return tl::make_unexpected(texture.error());
    verify::CookedCubemap map;
    map.range = constants.at("range").get<float>();
    for (std::size_t i = 0; i < map.windowedSh.size(); ++i) map.windowedSh[i] = vec3From(constants.at("windowed_sh").at(i));
    const Json& mips = constants.at("mips");
    const formats::TextureShape& shape = texture->shape();
    if (shape.faceCount != 6 || shape.mipCount != static_cast<int>(mips.size()))
        return failure(ErrorCode::Verification, context.action.asset,
                       fmt::format("found {} faces and {} mips, expected 6 and {}", shape.faceCount, shape.mipCount, mips.size()));
    for (int level = 0; level < shape.mipCount; ++level) {
        const Json& entry = mips.at(static_cast<std::size_t>(level));
        verify::CookedCubemap::Mip mip;
        mip.m = entry.at("m").get<double>();
        mip.bands = entry.at("bands").get<lighting::ShBands>();
        for (int face = 0; face < 6; ++face) {
            auto image = verify::decodeImage(*texture, {level, 0, face});
            if (!image) return tl::make_unexpected(image.error());
            mip.faces.push_back(std::move(*image));
        }
        map.mips.push_back(std::move(mip));
    }
    return map;
}

/// The first levels as rows of six faces, one below the other.
class CubemapPreview {
public:
    CubemapPreview(const verify::CookedCubemap& map, const verify::CubemapReference& reference, double key)
        : map_(map),
          reference_(reference),
          size_(sizeOf(0)),
          preview_(6 * size_, rowsOf(map), key),
          compared_(static_cast<std::size_t>(rowsOf(map))) {}
    int rowCount() const { return rowsOf(map_); }
    void fillRow(int y) {
        int mip = 0, row = y;
        while (row >= sizeOf(mip)) row -= sizeOf(mip++);
        const int size = sizeOf(mip);
        for (int x = 0; x < 6 * size; ++x) {
            if (!preview_.shows(x, y)) continue;
            const int face = x / size;
            const glm::dvec3 direction = lighting::cubeTexelDirection(face, x % size, row, size);
            const verify::CookedCubemap::Mip& level = map_.mips[static_cast<std::size_t>(mip)];
            const glm::vec3 stored(level.faces[static_cast<std::size_t>(face)].at(x % size, row));
            const glm::dvec3 truth =
                level.m > 0 ? reference_.prefiltered(direction, level.m, 1) : reference_.footprintMean(direction, size, kFootprintPlaces);
            const glm::dvec3 seen = verify::shadeCubemap(map_, mip, stored, direction);
            preview_.set(x, y, glm::vec3(truth), glm::vec3(seen));
            compared_[static_cast<std::size_t>(y)].push_back({mip, face, x % size, row, truth, seen});
        }
    }
    const Preview& preview() const { return preview_; }
    struct Compared {
        int mip, face, x, y;
        glm::dvec3 reference, cooked;
    };
    /// Every texel that is shown, row by row: some of every block of the levels that the picture has.
    const std::vector<std::vector<Compared>>& compared() const { return compared_; }

    static constexpr int kShownMips = 3;

private:
    static constexpr int kFootprintPlaces = 8;  ///< enough for a picture
    int sizeOf(int mip) const { return map_.mips[static_cast<std::size_t>(mip)].faces[0].width(); }
    static int rowsOf(const verify::CookedCubemap& map) {
        int rows = 0;
        for (std::size_t mip = 0; mip < map.mips.size() && mip < kShownMips; ++mip) rows += map.mips[mip].faces[0].width();
        return rows;
    }

    const verify::CookedCubemap& map_;
    const verify::CubemapReference& reference_;
    int size_;
    Preview preview_;
    std::vector<std::vector<Compared>> compared_;
};

/// The channel and texel of a block that are farthest off, of those that were compared.
verify::ErrorPlace worstInBlock(const std::vector<CubemapPreview::Compared>& compared, int mip, int face,
                                const verify::BlockErrors::Block& block, int size) {
    verify::ErrorPlace worst;
    for (const CubemapPreview::Compared& each : compared) {
        constexpr int kSize = verify::BlockErrors::kSize;
        if (each.mip != mip || each.face != face || each.x / kSize != block.x / kSize || each.y / kSize != block.y / kSize) continue;
        for (int channel = 0; channel < 3; ++channel) {
            if (worst.isKnown() && std::abs(each.cooked[channel] - each.reference[channel]) <= std::abs(worst.found - worst.reference))
                continue;
            worst.mip = mip;
            worst.face = face;
            worst.x = each.x;
            worst.y = each.y;
            worst.channel = channel;
            worst.normal = lighting::cubeTexelDirection(face, each.x, each.y, size);
            worst.reference = each.reference[channel];
            worst.found = each.cooked[channel];
        }
    }
    return worst;
}

/// The worst block of every level. The finer ones are met through the picture, the others through samples; both together cover all.
std::vector<verify::Violation> brokenCubemapBlocks(const verify::CookedCubemap& map, const CubemapPreview& picture,
                                                   const std::vector<verify::CubemapSample>& samples,
                                                   const std::vector<verify::CubemapResult>& results, double maxError) {
    std::vector<std::array<verify::BlockErrors, 6>> levels;
    for (const verify::CookedCubemap::Mip& mip : map.mips) {
        const int size = mip.faces[0].width();
        const verify::BlockErrors face(size, size);
        levels.push_back({face, face, face, face, face, face});
    }
    std::vector<CubemapPreview::Compared> compared;
    for (const auto& row : picture.compared()) compared.insert(compared.end(), row.begin(), row.end());
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (samples[i].isTexel && samples[i].mip >= CubemapPreview::kShownMips)
            compared.push_back({samples[i].mip, samples[i].face, samples[i].x, samples[i].y, results[i].reference, results[i].cooked});
    for (const CubemapPreview::Compared& each : compared) {
        const glm::dvec3 error = each.cooked - each.reference;
        levels[static_cast<std::size_t>(each.mip)][static_cast<std::size_t>(each.face)].add(each.x, each.y, glm::dot(error, error),
                                                                                            glm::dot(each.reference, each.reference));
    }
    std::vector<verify::Violation> violations;
    // A face that sees nothing but the tail of a lamp behind it is dark against the others, whatever it is against itself.
    constexpr double kLeastShare = 1e-4;
    for (std::size_t mip = 0; mip < levels.size(); ++mip) {
        double all = 0;
        for (const verify::BlockErrors& face : levels[mip]) all += face.meanSquare() / 6;
        for (std::size_t face = 0; face < 6; ++face)
            if (const auto block =
                    checkBlocks(levels[mip][face], fmt::format("mip {}, face {}, ", mip, face), maxError, violations, kLeastShare * all))
                violations.back().at =
                    worstInBlock(compared, static_cast<int>(mip), static_cast<int>(face), *block, map.mips[mip].faces[face].width());
    }
    return violations;
}

/// The map as a pixel sees it, times an area specular that is the pixel's own: reflected light over S, at texel centres.
Json ratioOf(const verify::CookedCubemap& map, const std::vector<verify::CubemapSample>& samples,
             const std::vector<verify::CubemapResult>& results) {
    verify::ErrorAccumulator ratios;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (!samples[i].isTexel) continue;
        const glm::dvec3 s = verify::shadeCubemap(map, samples[i].mip, glm::vec3(1.0f / map.range), samples[i].direction);
        for (int channel = 0; channel < 3; ++channel)
            ratios.add(results[i].reference[channel] / s[channel], results[i].cooked[channel] / s[channel]);
    }
    return {{"ratio_rms", ratios.referenceRms()}, {"ratio_rel_rms", ratios.figures().relRms}};
}

void checkBands(const verify::CookedCubemap& map, std::vector<verify::Violation>& violations) {
    for (std::size_t mip = 0; mip < map.mips.size(); ++mip) {
        const lighting::ShBands &found = map.mips[mip].bands, expected = verify::kernelBands(map.mips[mip].m);
        bool isRight = true;
        for (std::size_t l = 0; l < 3; ++l) isRight = isRight && std::abs(found[l] - expected[l]) <= verify::kBandTolerance;
        if (isRight) continue;
        violations.push_back({fmt::format("mip {}, band factors", mip), fmt::format("{:.4f}, {:.4f}, {:.4f}", found[0], found[1], found[2]),
                              fmt::format("{:.4f}, {:.4f}, {:.4f} of m {:.4f}", expected[0], expected[1], expected[2], map.mips[mip].m)});
    }
}

verify::LutAxis axisFrom(const Json& json) {
    return {json.at("count").get<int>(),   json.at("minimum").get<double>(), json.at("maximum").get<double>(),
            json.at("scale").get<float>(), json.at("offset").get<float>(),   json.at("factors").get<std::array<double, 4>>()};
}

/// Whether an axis decodes as its name says: an engine may go by either.
bool isAxis(const Json& json, const std::vector<fit::AxisMapping>& mappings) {
    return std::any_of(mappings.begin(), mappings.end(),
                       [&](const auto& mapping) { return json.at("of") == mapping.name && json.at("factors") == Json(mapping.factors); });
}

/// Reflected light over NoV (grazing on the left) and m (smooth on top), as far as the tables go: of constant light off a surface of F0
/// 0.6, and the worst error of all lights and F0 that they are judged by. Nothing after an interrupt.
std::optional<Preview> drawTables(const verify::CookedLut& tables, double key, const ActionContext& context) {
    constexpr int kAcross = 96, kDown = 48;
    const std::vector<verify::SpecularKernelEntries> shadings = verify::lutShadings(kTableF0);
    const std::size_t shown = static_cast<std::size_t>(std::ranges::find(kTableF0, 0.04) - kTableF0.begin());
    const auto ends = [](const verify::LutAxis& axis) {
        return std::minmax({axis.inverse(axis.at(0)), axis.inverse(axis.at(axis.count - 1))});
    };
    const auto [lowNoV, highNoV] = ends(tables.view);
    const auto [lowM, highM] = ends(tables.roughness);
    Preview preview(kAcross, kDown, key);
    const bool finished = forEachPiece(kDown, context, "verify " + context.action.asset, [&](std::size_t row) {
        const double m = lowM + (highM - lowM) * (static_cast<double>(row) + 0.5) / kDown;
        for (int x = 0; x < kAcross; ++x) {
            const double NoV = std::max(verify::kSmallestTableNoV, lowNoV + (highNoV - lowNoV) * (x + 0.5) / kAcross);
            const verify::LutResult found = verify::compareLut(tables, {NoV, m, false, false});
            const auto reflected = [&](const verify::SpecularKernelEntries& k, std::size_t shading) {
                return std::inner_product(k.begin(), k.end(), shadings[shading].begin(), 0.0);
            };
            double squares = 0, errors = 0;
            for (std::size_t i = 0; i < shadings.size(); ++i) {
                const double truth = reflected(found.reference, i), error = reflected(found.cooked, i) - truth;
                squares += truth * truth;
                errors += error * error;
            }
            const auto count = static_cast<double>(shadings.size());
            const double light = std::sqrt(squares / count), off = std::sqrt(errors / count);
            preview.set(x, static_cast<int>(row), glm::vec3(static_cast<float>(light)), glm::vec3(static_cast<float>(light + off)));
            // The last light is what the pictures keep.
            preview.set(x, static_cast<int>(row), glm::vec3(static_cast<float>(reflected(found.reference, shown))),
                        glm::vec3(static_cast<float>(reflected(found.cooked, shown))));
        }
    });
    if (!finished) return {};
    return preview;
}

/// The kernels that the scene shades with, for the views, m and F0 that its light maps are verified with. The verdict is of all that the
/// tables hold, and mostly of grazing views; what this error is worth depends on a map's light.
Json momentsOf(const verify::CookedLut& tables, const verify::LightMapShading& shading) {
    std::vector<verify::LutSample> samples;
    for (int i = 0; i < shading.viewCount; ++i) {
        const double NoV = lighting::fibonacciHemisphere(i, shading.viewCount).z;
        for (const double m : shading.m) samples.push_back({NoV, m, false, false});
    }
    std::vector<verify::LutResult> results(samples.size());
    tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) { results[i] = verify::compareLut(tables, samples[i]); });
    const TableMoments moments = tableMoments(results, shading.f0);
    return {{"kernel_moments", moments.reference}, {"error_moments", moments.error}};
}

/// Rows of one texture from firstRow (a multiple of the block height) on, at least rowCount of them as far as the map has them.
Result<Image<glm::vec4>> readRows(const formats::TextureReader& texture, int firstRow, int rowCount) {
    const formats::TextureShape& shape = texture.shape();
    const int blockHeight = formats::info(shape.format).blockHeight;
    const int blockRows = formats::blocksDown(shape.format, std::min(rowCount, shape.height - firstRow));
    Image<glm::vec4> rows(shape.width, std::min(blockRows * blockHeight, shape.height - firstRow));
    std::vector<std::byte> blocks(formats::bytesPerBlockRow(shape.format, shape.width) * static_cast<std::size_t>(blockRows));
    if (auto read = texture.readBlockRows({}, firstRow / blockHeight, blocks); !read) return tl::make_unexpected(read.error());
    verify::decodeRows(shape.format, blocks, rows.view());
    return rows;
}

verify::DominantFit dominantFitOf(const Json& asset) {
    const std::string name = asset.value("fit", "closed");
    if (name == "refined") return verify::DominantFit::Refined;
    if (name == "explained") return verify::DominantFit::Explained;
    return name == "refined-ambient" ? verify::DominantFit::RefinedAmbient : verify::DominantFit::Closed;
}

/// Exit radiance of a white Lambert surface under one dominant light.
glm::vec3 litBy(const glm::vec3& direction, const glm::vec3& intensity, const glm::vec3& normal) {
    const float cosine = std::max(glm::dot(normal, shaders::lcDominantDirection(direction, normal)), 0.0f);
    return cosine / std::numbers::pi_v<float> * intensity;
}

/// Squared errors of direction vectors, without and with the second texture.
struct ResidualGain {
    double coarse = 0, fine = 0;
    void add(const glm::dvec3& truth, const glm::dvec3& first, const glm::dvec3& both) {
        coarse += glm::dot(first - truth, first - truth);
        fine += glm::dot(both - truth, both - truth);
    }
    void merge(const ResidualGain& other) {
        coarse += other.coarse;
        fine += other.fine;
    }
};

/// A light as three vectors, one a channel: intensity times direction.
void addLight(const verify::DominantLightSample& truth, const verify::DominantLightSample& seen, int x, int y,
              verify::BlockErrors& blocks) {
    const auto unit = [](const glm::dvec3& v) { return glm::length(v) > 0 ? glm::normalize(v) : v; };
    double error = 0, reference = 0;
    for (int channel = 0; channel < 3; ++channel) {
        const glm::dvec3 difference = seen.intensity[channel] * unit(seen.direction) - truth.intensity[channel] * unit(truth.direction);
        error += glm::dot(difference, difference);
        reference += truth.intensity[channel] * truth.intensity[channel];
    }
    blocks.add(x, y, error, reference);
}

}  // namespace

Result<ActionOutcome> verifyCubemap(const ActionContext& context) {
    const Stopwatch watch;
    const Json& asset = context.upstream.at(0)->result.at("asset");
    const formats::EnvironmentOptions options = environmentOptions(asset.at("source"), context.action);
    const auto source = formats::loadEnvironment(context.action.inputs.at("source"), options);
    if (!source) return tl::make_unexpected(source.error());
    const auto colors = formats::linearConversion(options.colors);
    if (!colors) return tl::make_unexpected(colors.error());
    const auto map = readCubemap(context, asset);
    if (!map) return tl::make_unexpected(map.error());

    const verify::CubemapReference reference(source->environment);
    const std::vector<verify::CubemapSample> samples = verify::cubemapSamples(*map, {});
    std::vector<verify::CubemapResult> results(samples.size());
    CubemapPreview picture(*map, reference, glm::dot(reference.mean(), glm::dvec3(colors->luminanceWeights)));
    const std::size_t pictureRows = static_cast<std::size_t>(picture.rowCount());
    const bool finished = forEachPiece(samples.size() + pictureRows, context, "verify " + context.action.asset, [&](std::size_t index) {
        if (index < samples.size())
            results[index] = verify::compareCubemap(*map, reference, samples[index]);
        else
            picture.fillRow(static_cast<int>(index - samples.size()));
    });
    if (!finished) return interrupted(context);
    std::vector<verify::Violation> violations = brokenCubemapBlocks(*map, picture, samples, results, maxErrorOf(context));
    checkBands(*map, violations);
    ActionOutcome outcome =
        outcomeOf(verify::cubemapStages(*map, reference, samples, results, colors->luminanceWeights), context, watch, violations);
    outcome.result["light"] = ratioOf(*map, samples, results);
    if (auto written = picture.preview().write(context.folder, context.action.asset, outcome); !written)
        return tl::make_unexpected(written.error());
    return outcome;
}

Result<ActionOutcome> verifyTables(const ActionContext& context) {
    const Stopwatch watch;
    const Json& asset = context.upstream.at(0)->result.at("asset");
    const Json& constants = asset.at("constants");
    verify::CookedLut tables;
    const std::string viewAxis = constants.at("view").at("of"), roughnessAxis = constants.at("roughness").at("of");
    if (!isAxis(constants.at("view"), fit::viewMappings()) || !isAxis(constants.at("roughness"), fit::roughnessMappings()))
        return failure(ErrorCode::Verification, context.action.asset + ", texture axes",
                       fmt::format("found {} and {}, expected known ones with their own factors", viewAxis, roughnessAxis));
    const std::string lobe = asset.at("distribution"), normalization = asset.at("normalization");
    const auto known = lobeOf(lobe);
    if (!known || (normalization != "energy" && normalization != "halo3"))
        return failure(ErrorCode::Verification, context.action.asset,
                       fmt::format("found distribution {} and normalization {}, expected one of {}, and energy or halo3", lobe,
                                   normalization, fmt::join(kLobeNames, ", ")));
    tables.lobe = *known;
    tables.normalization =
        normalization == "halo3" ? lighting::CookTorranceNormalization::Halo3 : lighting::CookTorranceNormalization::Energy;
    tables.view = axisFrom(constants.at("view"));
    tables.roughness = axisFrom(constants.at("roughness"));
    const std::array<std::string, 3> roles = {"c0236", "d0236", "cd78"};
    for (std::size_t i = 0; i < roles.size(); ++i) {
        const auto texture = openTexture(context.upstreamFolder, asset, roles[i]);
        if (!texture) return tl::make_unexpected(texture.error());
        auto image = verify::decodeImage(*texture, {});
        if (!image) return tl::make_unexpected(image.error());
        if (image->width() != tables.view.count || image->height() != tables.roughness.count)
            return failure(ErrorCode::Verification, context.action.asset + ", texture " + roles[i],
                           fmt::format("found {} x {} texels, expected {} x {} as its axes", image->width(), image->height(),
                                       tables.view.count, tables.roughness.count));
        tables.textures[i] = std::move(*image);
        tables.scale[i] = vec4From(constants.at(roles[i] + "_scale"));
        tables.bias[i] = vec4From(constants.at(roles[i] + "_bias"));
    }
    const auto samples = verify::lutSamples(tables, kRandomTableSamples, 1);
    std::vector<verify::LutResult> results(samples.size());
    if (!forEachPiece(samples.size(), context, "verify " + context.action.asset,
                      [&](std::size_t i) { results[i] = verify::compareLut(tables, samples[i]); }))
        return interrupted(context);
    std::vector<verify::Violation> violations;
    const verify::LutStepError off = verify::lutStepError(tables, samples, results);
    if (off.steps > kTableSteps)
        violations.push_back(
            {fmt::format("texture {}, channel {}, texel of NoV {:.4g} and m {:.4g}", roles[off.entry / 4], off.entry % 4, off.NoV, off.m),
             fmt::format("an error of {:.4g} steps of 16 bits", off.steps), fmt::format("at most {}", kTableSteps),
             verify::lutPlace(tables, off.NoV, off.m)});
    const verify::LutKeys keys = verify::lutKeys(samples, results, kTableF0);
    std::vector<verify::LutBounds> bounds(static_cast<std::size_t>(tables.view.count - 1));
    if (!forEachPiece(bounds.size(), context, "verify " + context.action.asset, [&](std::size_t cell) {
            const int viewCell = static_cast<int>(cell);
            bounds[cell] = verify::largestOf(tables, viewCell, verify::boundLut(tables, viewCell, keys, kTableF0));
        }))
        return interrupted(context);
    verify::LutBounds bound;
    for (const verify::LutBounds& each : bounds) bound.raise(each);
    const auto preview = drawTables(tables, keys.shaded, context);
    if (!preview) return interrupted(context);
    ActionOutcome outcome = outcomeOf(verify::lutStages(tables, samples, results, kTableF0, bound), context, watch, violations);
    if (auto written = preview->write(context.folder, context.action.asset, outcome); !written) return tl::make_unexpected(written.error());
    const Json& parameters = context.action.parameters;
    if (parameters.contains("shading")) outcome.result["light"] = momentsOf(tables, shadingFromJson(parameters.at("shading")));
    return outcome;
}

Result<ActionOutcome> verifyDominant(const ActionContext& context) {
    const Stopwatch watch;
    const Json& asset = context.upstream.at(0)->result.at("asset");
    const auto source = openLightMap(context, asset.at("source").at("description"));
    if (!source) return tl::make_unexpected(source.error());
    LightMapSource& bake = **source;
    const auto direction = openTexture(context.upstreamFolder, asset, "direction");
    if (!direction) return tl::make_unexpected(direction.error());
    const auto intensity = openTexture(context.upstreamFolder, asset, "intensity");
    if (!intensity) return tl::make_unexpected(intensity.error());
    const Json& constants = asset.at("constants");
    const float residualScale = constants.at("residual_scale").get<float>(), residualCentre = constants.at("residual_centre").get<float>();
    std::optional<formats::TextureReader> residual;
    if (residualScale != 0) {
        auto opened = openTexture(context.upstreamFolder, asset, "residual");
        if (!opened) return tl::make_unexpected(opened.error());
        residual = std::move(*opened);
    }
    for (const formats::TextureReader* texture : {&*direction, &*intensity, residual ? &*residual : &*direction})
        if (texture->shape().width != bake.width() || texture->shape().height != bake.height())
            return failure(ErrorCode::Verification, context.action.asset,
                           fmt::format("found textures of {} x {} texels, expected {} x {} as the source", texture->shape().width,
                                       texture->shape().height, bake.width(), bake.height()));
    const auto key = surveyKey(bake, context);
    if (!key) return tl::make_unexpected(key.error());

    const verify::CookedDominant map{constants.at("direction_scale").get<float>(),
                                     constants.at("direction_bias").get<float>(),
                                     constants.at("intensity_range").get<float>(),
                                     bake.width(),
                                     bake.height(),
                                     dominantFitOf(asset)};
    const verify::LightMapShading materials = shadingFromJson(context.action.parameters.at("shading"));
    const verify::DominantShading shading{materials.m, materials.f0, materials.viewCount, verify::dominantStride(map.width, map.height)};
    const verify::DominantVerifier verifier(map, shading, bake.luminanceWeights(), *key);
    const auto groundTruth = GroundTruth::open(context, bake, asset.at("source").at("description"));
    if (!groundTruth) return tl::make_unexpected(groundTruth.error());
    Preview preview(bake.width(), bake.height(), *key);
    // A search a texel is dear: four of a block's sixteen tell its faults.
    const int every = map.fit == verify::DominantFit::Closed ? 1 : 2;
    struct Part {
        verify::DominantErrors errors;
        verify::BlockErrors blocks;
        ResidualGain gain;
        std::vector<verify::DominantTruthPlace> truthPlaces;
    };
    Part whole{verify::DominantErrors(*key), verify::BlockErrors(bake.width(), 0), {}, {}};
    const auto verified = foldBands<Part>(
        bake.stripCount(), context, "verify " + context.action.asset,
        [&](int index) -> Result<Part> {
            const int firstRow = bake.stripFirstRow(index), rowCount = bake.stripRows(index);
            Part part{verify::DominantErrors(*key), verify::BlockErrors(bake.width(), rowCount, firstRow), {}, {}};
            const auto reference = bake.stripWithMargin(index, 0, 1);
            if (!reference) return tl::make_unexpected(reference.error());
            auto directions = readRows(*direction, firstRow, rowCount + 1);
            if (!directions) return tl::make_unexpected(directions.error());
            const std::vector<glm::vec4> coarse(directions->texels().begin(), directions->texels().end());
            if (residual) {
                const auto left = readRows(*residual, firstRow, rowCount + 1);
                if (!left) return tl::make_unexpected(left.error());
                for (std::size_t i = 0; i < left->texels().size(); ++i)
                    directions->texels()[i] =
                        glm::vec4(shaders::lcDominantStored(glm::vec3(directions->texels()[i]), glm::vec3(left->texels()[i]), residualScale,
                                                            residualCentre),
                                  1.0f);
            }
            auto intensities = readRows(*intensity, firstRow, rowCount + 1);
            if (!intensities) return tl::make_unexpected(intensities.error());
            const verify::DecodedDominantRows rows{firstRow, std::move(*directions), std::move(*intensities)};
            for (int y = 0; y < rowCount; ++y)
                for (int x = 0; x < map.width; ++x) {
                    if (reference->covered.at(x, y) == 0) continue;
                    if (!preview.shows(x, firstRow + y) && (x % every != 0 || y % every != 0)) continue;
                    const glm::vec3 normal = reference->normal.at(x, y);
                    const auto seen = verifier.decode(rows, x, firstRow + y);
                    const auto truth = verifier.reference(reference->sh.at(x, y), glm::dvec3(normal), seen);
                    addLight(truth, seen, x, firstRow + y, part.blocks);
                    part.gain.add(truth.direction,
                                  map.directionScale * glm::vec3(coarse[static_cast<std::size_t>(y * map.width + x)]) + map.directionBias,
                                  seen.direction);
                    const glm::vec3 lit = litBy(glm::vec3(truth.direction), glm::vec3(truth.intensity), normal);
                    const glm::vec3 litAsSeen = litBy(glm::vec3(seen.direction), glm::vec3(seen.intensity), normal);
                    preview.set(x, firstRow + y, lit, litAsSeen);
                }
            part.errors = verifier.verifyRows(rows, *reference, firstRow, rowCount);
            const auto traced = groundTruth->within(*reference, firstRow, rowCount);
            if (!traced) return tl::make_unexpected(traced.error());
            part.truthPlaces = dominantPlaces(*traced, *reference, verifier, rows, map.fit == verify::DominantFit::RefinedAmbient);
            return part;
        },
        [&](const Part& part) {
            whole.errors.merge(part.errors);
            whole.blocks.merge(part.blocks);
            whole.gain.merge(part.gain);
            whole.truthPlaces.insert(whole.truthPlaces.end(), part.truthPlaces.begin(), part.truthPlaces.end());
        });
    if (!verified) return tl::make_unexpected(verified.error());
    std::vector<verify::Violation> violations;
    if (const auto block = checkBlocks(whole.blocks, "", maxErrorOf(context), violations))
        if (const auto texels = coveredOfBlock(bake, block->x, block->y); texels && !texels->empty()) {
            verify::ErrorPlace& at = violations.back().at;
            at.x = texels->front().x;
            at.y = texels->front().y;
            at.channel = -1;
            at.normal = glm::dvec3(texels->front().normal);
        }
    const ResidualGain& gain = whole.gain;
    if (residual && gain.fine > 1.05 * gain.coarse)
        violations.push_back({"texture residual", fmt::format("a squared error of directions of {:.3g}", gain.fine),
                              fmt::format("no more than without it ({:.3g}): it belongs to something else", gain.coarse)});
    ActionOutcome outcome = outcomeOf(whole.errors.stages(), context, watch, violations);
    outcome.result["key"] = *key;
    outcome.result["light"] = {{"specular_rms", whole.errors.referenceRms()}};
    if (!whole.truthPlaces.empty()) outcome.result["ground_truth"] = toJson(verify::dominantTruth(whole.truthPlaces));
    outcome.result["measures"] = {{"direction_error_degrees_mean", whole.errors.meanDirectionError()},
                                  {"direction_error_degrees_max", whole.errors.maxDirectionError()},
                                  {"unexplained_energy_stored", whole.errors.unexplainedStored()},
                                  {"unexplained_energy_reference", whole.errors.unexplainedReference()},
                                  {"shaded_every_texels", shading.stride}};
    if (auto written = preview.write(context.folder, context.action.asset, outcome); !written) return tl::make_unexpected(written.error());
    return outcome;
}

}  // namespace lightcook::pipeline
