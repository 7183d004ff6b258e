#include "verify/light_map/layouts.h"

#include <algorithm>
#include <span>

namespace lightcook::verify::layouts {

namespace {

using formats::ErrorCode;

/// Copies a constant of exactly out.size() finite values; what is wrong with it otherwise.
std::optional<formats::Error> readConstant(const CookedLightMap& map, const std::string& name, std::span<float> out) {
    const std::string place = "light map layout " + map.layout + ", constant " + name;
    const auto found = map.constants.find(name);
    if (found == map.constants.end()) return formats::Error{ErrorCode::WrongShape, place, "not found, expected it in the manifest"};
    if (found->second.size() != out.size())
        return formats::Error{ErrorCode::WrongShape, place,
                              "found " + std::to_string(found->second.size()) + " values, expected " + std::to_string(out.size())};
    if (!std::ranges::all_of(found->second, [](float v) { return std::isfinite(v); }))
        return formats::Error{ErrorCode::ValueNotFinite, place, "found NaN or infinity, expected finite values"};
    std::ranges::copy(found->second, out.begin());
    return std::nullopt;
}

std::optional<formats::Error> readLuminance(const CookedLightMap& map, glm::vec3& out) {
    std::array<float, 3> weights{};
    if (auto error = readConstant(map, "luminance", weights)) return error;
    out = glm::vec3(weights[0], weights[1], weights[2]);
    return std::nullopt;
}

/// Luvw or LuvwLinear.
template <class AnyLuvw>
formats::Result<Layout> readLuvw(const CookedLightMap& map) {
    AnyLuvw luvw;
    std::array<float, 4> neutral{};
    if (auto error = readConstant(map, "range", luvw.k.range)) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "span", luvw.k.span)) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "neutral", neutral)) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "root", std::span(&luvw.k.root, 1))) return tl::make_unexpected(*error);
    luvw.k.neutral = glm::vec4(neutral[0], neutral[1], neutral[2], neutral[3]);
    if constexpr (Zonal<AnyLuvw>)
        if (auto error = readLuminance(map, luvw.k.luminance)) return tl::make_unexpected(*error);
    return luvw;
}

/// Ratio or Zh3.
template <class AnyRatio>
formats::Result<Layout> readRatio(const CookedLightMap& map) {
    AnyRatio ratio;
    if (auto error = readConstant(map, "range", std::span(&ratio.k.range, 1))) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "scale", ratio.k.scale)) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "bias", ratio.k.bias)) return tl::make_unexpected(*error);
    if constexpr (Zonal<AnyRatio>)
        if (auto error = readLuminance(map, ratio.k.luminance)) return tl::make_unexpected(*error);
    return ratio;
}

/// `count` tables of the given size from constant `name`, values in the order of the shader's struct.
template <class Table>
std::optional<formats::Error> readTables(const CookedLightMap& map, const std::string& name, std::size_t count, std::vector<Table>& out) {
    std::vector<float> values(count * sizeof(Table) / sizeof(float));
    if (auto error = readConstant(map, name, values)) return error;
    out.resize(count);
    if (count > 0) std::memcpy(static_cast<void*>(out.data()), values.data(), count * sizeof(Table));
    return std::nullopt;
}

/// The index by blocks from [cluster, count, cluster, count ...].
std::optional<formats::Error> readIndex(const CookedLightMap& map, std::size_t clusterCount, BasisTables& tables) {
    const std::string place = "light map layout " + map.layout + ", constant index_runs";
    const auto found = map.constants.find("index_runs");
    if (found == map.constants.end()) return formats::Error{ErrorCode::WrongShape, place, "not found, expected it in the manifest"};
    const std::vector<float>& runs = found->second;
    tables.blocksAcross = (map.width + 3) / 4;
    const std::size_t blocks = static_cast<std::size_t>(tables.blocksAcross) * static_cast<std::size_t>((map.height + 3) / 4);
    const auto isWhole = [](float v, float largest) { return v >= 0 && v <= largest && v == std::floor(v); };
    for (std::size_t i = 0; i + 1 < runs.size(); i += 2) {
        if (!isWhole(runs[i], static_cast<float>(clusterCount) - 1) ||
            !isWhole(runs[i + 1], static_cast<float>(blocks - tables.index.size())))
            return formats::Error{ErrorCode::WrongShape, place,
                                  "found a run of " + std::to_string(runs[i + 1]) + " blocks of cluster " + std::to_string(runs[i]) +
                                      ", expected clusters below " + std::to_string(clusterCount) + " and " + std::to_string(blocks) +
                                      " blocks in all"};
        tables.index.insert(tables.index.end(), static_cast<std::size_t>(runs[i + 1]), static_cast<std::uint8_t>(runs[i]));
    }
    if (tables.index.size() != blocks)
        return formats::Error{ErrorCode::WrongShape, place,
                              "found " + std::to_string(tables.index.size()) + " blocks, expected " + std::to_string(blocks)};
    return std::nullopt;
}

template <int kCodes, std::size_t kResiduals>
formats::Result<Layout> readBasis(const CookedLightMap& map) {
    auto tables = std::make_shared<BasisTables>();
    float clusters = 0;
    if (auto error = readConstant(map, "range", std::span(&tables->range, 1))) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "neutral", std::span(&tables->neutral, 1))) return tl::make_unexpected(*error);
    if (auto error = readConstant(map, "clusters", std::span(&clusters, 1))) return tl::make_unexpected(*error);
    if (!(clusters >= 1 && clusters <= 256) || clusters != std::floor(clusters))
        return formats::failure(ErrorCode::WrongShape, "light map layout " + map.layout + ", constant clusters",
                                "found " + std::to_string(clusters) + ", expected a whole number from 1 to 256");
    const auto count = static_cast<std::size_t>(clusters);
    const auto error = kCodes == 3 ? readTables(map, "code", count, tables->first3) : readTables(map, "code", count, tables->first4);
    if (error) return tl::make_unexpected(*error);
    std::vector<shaders::LcBasisResidual> residual;
    if (auto failed = readTables(map, "residual", kResiduals * count, residual)) return tl::make_unexpected(*failed);
    for (std::size_t layer = 0; layer < kResiduals; ++layer) {
        const auto first = residual.begin() + static_cast<std::ptrdiff_t>(layer * count);
        tables->residual.emplace_back(first, first + static_cast<std::ptrdiff_t>(count));
    }
    if (auto failed = readIndex(map, count, *tables)) return tl::make_unexpected(*failed);
    return Basis<kCodes, kResiduals>{std::move(tables)};
}

template <class RangeOnly>
formats::Result<Layout> readRangeOnly(const CookedLightMap& map) {
    RangeOnly layout;
    if (auto error = readConstant(map, "range", std::span(&layout.k.range, 1))) return tl::make_unexpected(*error);
    return layout;
}

}  // namespace

formats::Result<Layout> layoutOf(const CookedLightMap& map) {
    if (map.layout == "raw") return readRangeOnly<Raw>(map);
    if (map.layout == "flat") return readRangeOnly<Flat>(map);
    if (map.layout == "luvw") return readLuvw<Luvw>(map);
    if (map.layout == "luvw-linear") return readLuvw<LuvwLinear>(map);
    if (map.layout == "ratio") return readRatio<Ratio>(map);
    if (map.layout == "zh3") return readRatio<Zh3>(map);
    if (map.layout == "basis-3") return readBasis<3, 0>(map);
    if (map.layout == "basis-4") return readBasis<4, 0>(map);
    if (map.layout == "basis-8") return readBasis<4, 1>(map);
    if (map.layout == "basis-12") return readBasis<4, 2>(map);
    if (map.layout == "basis-16") return readBasis<4, 3>(map);
    return formats::failure(
        ErrorCode::WrongShape, "light map layout",
        "found \"" + map.layout + "\", expected raw, flat, luvw, luvw-linear, ratio, zh3, basis-3, basis-4, basis-8, basis-12 or basis-16");
}

std::vector<LightMapVerifier::TextureNeed> texturesOf(const Layout& layout) {
    switch (layout.index()) {
        case 0:
            return {{"sh", 9}};
        case 1:
            return {{"exit", 1}};
        case 2:
            return {{"luvw_first", 9}, {"luvw_second", 9}};
        case 3:
            return {{"luvw_first", 5}, {"luvw_second", 5}};
        case 4:
            return {{"l0", 1}, {"ratio", 8}};
        case 5:
            return {{"l0", 1}, {"ratio", 4}};
        case 6:
        case 7:
            return {{"l0", 1}, {"code", 1}};
        default:
            return {{"l0", 1}, {"code", 1}, {"residual", static_cast<int>(layout.index()) - 7}};
    }
}

}  // namespace lightcook::verify::layouts
