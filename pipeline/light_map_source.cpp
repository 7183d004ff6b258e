#include "pipeline/light_map_source.h"

#include <fmt/format.h>

#include <algorithm>

namespace pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::LightMapBand;
using formats::Result;

/// Decoded bands that one map keeps [bytes]: a 1024 x 1024 map whole, a larger one in part.
constexpr std::size_t kKeptBytes = std::size_t{192} << 20;
constexpr std::size_t kBytesPerTexel = sizeof(lighting::ShRgb) + sizeof(std::uint8_t) + sizeof(glm::vec3);

template <class T>
void copyRows(formats::ImageView<const T> source, int sourceRow, formats::ImageView<T> out, int outRow, int count) {
    for (int y = 0; y < count; ++y) std::copy_n(source.row(sourceRow + y), source.width, out.row(outRow + y));
}

constexpr std::pair<formats::ShPhase, const char*> kPhases[] = {{formats::ShPhase::None, "none"},
                                                                {formats::ShPhase::CondonShortley, "condon-shortley"}};
constexpr std::pair<formats::ShFrame, const char*> kFrames[] = {{formats::ShFrame::World, "world"}, {formats::ShFrame::Tangent, "tangent"}};
constexpr std::pair<formats::ShQuantity, const char*> kQuantities[] = {{formats::ShQuantity::Radiance, "radiance"},
                                                                       {formats::ShQuantity::Irradiance, "irradiance"}};
constexpr std::pair<formats::LightUnits, const char*> kUnits[] = {{formats::LightUnits::Radiometric, "radiometric"},
                                                                  {formats::LightUnits::Game, "game"}};

template <class Enum, std::size_t N>
const char* nameOf(const std::pair<Enum, const char*> (&table)[N], Enum value) {
    return std::find_if(std::begin(table), std::end(table), [&](const auto& row) { return row.first == value; })->second;
}
template <class Enum, std::size_t N>
Enum valueOf(const std::pair<Enum, const char*> (&table)[N], const std::string& name) {
    const auto row = std::find_if(std::begin(table), std::end(table), [&](const auto& each) { return each.second == name; });
    if (row == std::end(table)) throw std::out_of_range("'" + name + "'");
    return row->first;
}

}  // namespace

Result<std::shared_ptr<LightMapSource>> LightMapSource::open(const std::filesystem::path& file,
                                                             const formats::LightMapDescription& description) {
    auto reader = formats::LightMapReader::open(file, description);
    if (!reader) return tl::make_unexpected(reader.error());
    return std::shared_ptr<LightMapSource>(new LightMapSource(std::move(*reader)));
}

Result<std::shared_ptr<const LightMapBand>> LightMapSource::band(int index) {
    std::shared_ptr<Slot> slot;
    {
        const std::lock_guard lock(mutex_);
        auto& entry = slots_[index];
        if (!entry) entry = std::make_shared<Slot>();
        slot = entry;
    }
    const std::lock_guard lock(slot->mutex);  // two threads that want one band decode it once
    if (!slot->band) {
        auto band = reader_.read(index * kBandRows, bandRows(index));
        if (!band) return tl::make_unexpected(band.error());
        slot->band = std::make_shared<const LightMapBand>(std::move(*band));
    }
    const auto result = slot->band;
    keep(index);
    return result;
}

void LightMapSource::keep(int index) {
    const std::size_t bandBytes = kBytesPerTexel * static_cast<std::size_t>(width()) * kBandRows;
    const std::lock_guard lock(mutex_);
    leastRecentlyUsed_.remove(index);
    leastRecentlyUsed_.push_back(index);
    while (leastRecentlyUsed_.size() > 1 && leastRecentlyUsed_.size() * bandBytes > kKeptBytes) {
        slots_.erase(leastRecentlyUsed_.front());
        leastRecentlyUsed_.pop_front();
    }
}

Result<LightMapBand> LightMapSource::bandWithMargin(int index, int above, int below) {
    const int first = std::max(0, index * kBandRows - above);
    const int end = std::min(height(), index * kBandRows + bandRows(index) + below);
    LightMapBand result;
    result.firstRow = first;
    result.sh = formats::Image<lighting::ShRgb>(width(), end - first);
    result.covered = formats::Image<std::uint8_t>(width(), end - first);
    result.normal = formats::Image<glm::vec3>(width(), end - first);
    for (int row = first; row < end;) {
        const auto source = band(row / kBandRows);
        if (!source) return tl::make_unexpected(source.error());
        const int sourceRow = row - (*source)->firstRow;
        const int count = std::min((*source)->sh.height() - sourceRow, end - row);
        copyRows((*source)->sh.view(), sourceRow, result.sh.view(), row - first, count);
        copyRows((*source)->covered.view(), sourceRow, result.covered.view(), row - first, count);
        copyRows((*source)->normal.view(), sourceRow, result.normal.view(), row - first, count);
        row += count;
    }
    return result;
}

Json toJson(const formats::LightMapDescription& description) {
    return {{"layout", description.layout},
            {"phase", nameOf(kPhases, description.phase)},
            {"frame", nameOf(kFrames, description.frame)},
            {"quantity", nameOf(kQuantities, description.quantity)},
            {"light_units", nameOf(kUnits, description.lightUnits)},
            {"color_source", description.colors.source},
            {"color_working", description.colors.working},
            {"color_config", description.colors.config.string()},
            {"repair", description.repair}};
}

Result<formats::LightMapDescription> lightMapDescriptionFromJson(const Json& json, const std::string& subject) {
    try {
        formats::LightMapDescription description;
        description.layout = json.at("layout").get<std::string>();
        description.phase = valueOf(kPhases, json.at("phase").get<std::string>());
        description.frame = valueOf(kFrames, json.at("frame").get<std::string>());
        description.quantity = valueOf(kQuantities, json.at("quantity").get<std::string>());
        description.lightUnits = valueOf(kUnits, json.at("light_units").get<std::string>());
        description.colors.source = json.at("color_source").get<std::string>();
        description.colors.working = json.at("color_working").get<std::string>();
        description.colors.config = json.at("color_config").get<std::string>();
        description.repair = json.at("repair").get<bool>();
        return description;
    } catch (const std::exception& mistake) {
        return failure(ErrorCode::FileUnreadable, subject, fmt::format("found {}, expected a light map's description", mistake.what()));
    }
}

}  // namespace pipeline
