#include "verify/light_map/layouts.h"

#include <algorithm>
#include <span>

namespace lightcook::verify::layouts {

namespace {

using formats::ErrorCode;

/// Copies the constant `name` to `out`. Returns an error unless it has exactly out.size() finite values.
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

/// Layouts whose only constant is a range.
template <class Layout>
concept RangeOnly = sizeof(Layout::k) == sizeof(float);

template <RangeOnly AnyLayout>
std::optional<formats::Error> readConstants(const CookedLightMap& map, AnyLayout& layout) {
    return readConstant(map, "range", std::span(&layout.k.range, 1));
}

std::optional<formats::Error> readConstants(const CookedLightMap& map, Flat2& layout) {
    if (auto error = readConstant(map, "range", std::span(&layout.k.range, 1))) return error;
    return readConstant(map, "share", std::span(&layout.k.share, 1));
}

template <LinearExitLayout AnyLayout>
std::optional<formats::Error> readConstants(const CookedLightMap&, AnyLayout&) {
    return std::nullopt;
}

std::optional<formats::Error> readConstants(const CookedLightMap&, Rnm&) {
    return std::nullopt;
}

std::optional<formats::Error> readConstants(const CookedLightMap& map, Halo3& layout) {
    return readConstant(map, "range", layout.k.range);
}

/// Layouts with ratios of coefficients.
template <class Layout>
concept WithRatios = RatioFamily<Layout> || DecodedBeforeFilter<Layout>;

template <WithRatios Ratio>
std::optional<formats::Error> readConstants(const CookedLightMap& map, Ratio& layout) {
    if (auto error = readConstant(map, "range", std::span(&layout.k.range, 1))) return error;
    if (auto error = readConstant(map, "scale", layout.k.scale)) return error;
    return readConstant(map, "bias", layout.k.bias);
}

template <HdrFamily Hdr>
std::optional<formats::Error> readConstants(const CookedLightMap& map, Hdr& layout) {
    if (auto error = readConstant(map, "range", std::span(&layout.k.range, 1))) return error;
    if (auto error = readConstant(map, "bias", layout.k.bias)) return error;
    if constexpr (requires { layout.k.share; }) return readConstant(map, "share", std::span(&layout.k.share, 1));
    return std::nullopt;
}

std::optional<formats::Error> readConstants(const CookedLightMap& map, UnrealHq& layout) {
    for (const auto& [name, out] : {std::pair("scale0", &layout.k.scale0), std::pair("add0", &layout.k.add0),
                                    std::pair("scale1", &layout.k.scale1), std::pair("add1", &layout.k.add1)}) {
        std::array<float, 4> values{};
        if (auto error = readConstant(map, name, values)) return error;
        *out = glm::vec4(values[0], values[1], values[2], values[3]);
    }
    return std::nullopt;
}

/// Reads `count` tables from the constant `name`, whose values are in the order of the shader's struct.
template <class Table>
std::optional<formats::Error> readTables(const CookedLightMap& map, const std::string& name, std::size_t count, std::vector<Table>& out) {
    std::vector<float> values(count * sizeof(Table) / sizeof(float));
    if (auto error = readConstant(map, name, values)) return error;
    out.resize(count);
    if (count > 0) std::memcpy(static_cast<void*>(out.data()), values.data(), count * sizeof(Table));
    return std::nullopt;
}

/// Takes the clusters of all blocks from the index.
std::optional<formats::Error> takeIndex(const CookedLightMap& map, std::size_t clusterCount, BasisTables& tables) {
    const std::string place = "light map layout " + map.layout + ", texture index";
    const int side = tables.blockSide = map.clusterBlock;
    tables.blocksAcross = (map.width + side - 1) / side;
    const std::size_t blocks = static_cast<std::size_t>(tables.blocksAcross) * static_cast<std::size_t>((map.height + side - 1) / side);
    if (map.clusterOfBlock.size() != blocks)
        return formats::Error{ErrorCode::WrongShape, place,
                              "found " + std::to_string(map.clusterOfBlock.size()) + " blocks, expected " + std::to_string(blocks)};
    const std::uint8_t largest = *std::ranges::max_element(map.clusterOfBlock);
    if (largest >= clusterCount)
        return formats::Error{ErrorCode::WrongShape, place,
                              "found cluster " + std::to_string(largest) + ", expected clusters below " + std::to_string(clusterCount)};
    tables.index = map.clusterOfBlock;
    return std::nullopt;
}

/// Reads the clusters of all blocks from runs: [cluster, count, cluster, count ...].
std::optional<formats::Error> readIndex(const CookedLightMap& map, std::size_t clusterCount, BasisTables& tables) {
    if (!map.clusterOfBlock.empty()) return takeIndex(map, clusterCount, tables);
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

/// Reads the tables of a learned layout.
std::optional<formats::Error> readBasis(const CookedLightMap& map, int codeCount, std::size_t residualCount, BasisTables& tables) {
    float clusters = 0;
    if (auto error = readConstant(map, "range", std::span(&tables.range, 1))) return error;
    if (auto error = readConstant(map, "neutral", std::span(&tables.neutral, 1))) return error;
    if (auto error = readConstant(map, "clusters", std::span(&clusters, 1))) return error;
    if (!(clusters >= 1 && clusters <= 256) || clusters != std::floor(clusters))
        return formats::Error{ErrorCode::WrongShape, "light map layout " + map.layout + ", constant clusters",
                              "found " + std::to_string(clusters) + ", expected a whole number from 1 to 256"};
    const auto count = static_cast<std::size_t>(clusters);
    if (auto error = codeCount == 3 ? readTables(map, "code", count, tables.first3) : readTables(map, "code", count, tables.first4))
        return error;
    std::vector<shaders::LcBasisResidual> residual;
    if (auto error = readTables(map, "residual", residualCount * count, residual)) return error;
    for (std::size_t layer = 0; layer < residualCount; ++layer) {
        const auto first = residual.begin() + static_cast<std::ptrdiff_t>(layer * count);
        tables.residual.emplace_back(first, first + static_cast<std::ptrdiff_t>(count));
    }
    return readIndex(map, count, tables);
}

template <LightMapLayout kId>
std::optional<formats::Error> readConstants(const CookedLightMap& map, Basis<kId>& layout) {
    auto tables = std::make_shared<BasisTables>();
    if (auto error = readBasis(map, Basis<kId>::kCodeCount, Basis<kId>::kResidualCount, *tables)) return error;
    layout.tables = std::move(tables);
    return std::nullopt;
}

template <class AnyLayout>
formats::Result<Layout> read(const CookedLightMap& map) {
    AnyLayout layout;
    if (auto error = readConstants(map, layout)) return tl::make_unexpected(*error);
    return layout;
}

/// Returns read<> for each alternative of the variant.
template <std::size_t... kIndices>
constexpr auto readersOf(std::index_sequence<kIndices...>) {
    return std::array{&read<std::variant_alternative_t<kIndices, Layout>>...};
}
constexpr auto kReaders = readersOf(std::make_index_sequence<std::variant_size_v<Layout>>());

}  // namespace

formats::Result<Layout> layoutOf(const CookedLightMap& map) {
    if (const auto layout = formats::lightMapLayoutFromName(map.layout)) return kReaders[static_cast<std::size_t>(*layout)](map);
    return formats::failure(ErrorCode::WrongShape, "light map layout",
                            "found \"" + map.layout + "\", expected " + formats::listOfNames(formats::allLightMapLayouts()));
}

std::vector<LightMapVerifier::TextureNeed> texturesOf(const Layout& layout) {
    std::vector<LightMapVerifier::TextureNeed> needs;
    for (const formats::LightMapTextureInfo& texture : infoOf(layout).textures)
        needs.push_back({std::string(texture.name), texture.layerCount, texture.side});
    return needs;
}

}  // namespace lightcook::verify::layouts
