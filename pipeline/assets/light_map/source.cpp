#include "pipeline/assets/light_map/source.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "formats/fireflies.h"
#include "formats/light_map_conventions.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::LightMapStrip;
using formats::Result;

constexpr std::size_t kBytesPerTexel = sizeof(lighting::ShRgb) + sizeof(std::uint8_t) + sizeof(glm::vec3);

template <class T>
void copyRows(formats::ImageView<const T> source, int sourceRow, formats::ImageView<T> out, int outRow, int count) {
    for (int y = 0; y < count; ++y) std::copy_n(source.row(sourceRow + y), source.width, out.row(outRow + y));
}

/// Returns the convention of a name in an action's parameters; throws for an unknown one.
template <class Enum>
Enum conventionAt(const Json& json, const char* key) {
    const std::string name = json.at(key).get<std::string>();
    const std::optional<Enum> convention = formats::conventionFromName<Enum>(name);
    if (!convention) throw std::out_of_range("'" + name + "'");
    return *convention;
}

}  // namespace

Result<LightMapSource*> LightMapSources::open(const std::filesystem::path& file, const formats::LightMapDescription& description) {
    const std::string key =
        std::filesystem::absolute(file).lexically_normal().string() + toJson(description).dump() + description.colors.config.string();
    const std::lock_guard lock(mutex_);
    if (const auto known = sources_.find(key); known != sources_.end()) return known->second.get();
    auto reader = formats::LightMapReader::open(file, description);
    if (!reader) return tl::make_unexpected(reader.error());
    std::unique_ptr<LightMapSource> source(
        new LightMapSource(*this, std::move(*reader), {file.string(), description.fireflyLimit, description.repair}));
    return sources_.emplace(key, std::move(source)).first->second.get();
}

void LightMapSources::keep(LightMapSource& source, int index, std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    const auto known =
        std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.source == &source && kept.index == index; });
    if (known == kept_.end())
        keptBytes_ += bytes;
    else
        kept_.erase(known);
    kept_.push_back({&source, index, bytes});
    while (keptBytes_ > kKeptBytes && kept_.size() > 1) {
        const Kept oldest = kept_.front();
        kept_.pop_front();
        keptBytes_ -= oldest.bytes;
        const std::lock_guard sourceLock(oldest.source->mutex_);
        oldest.source->slots_.erase(oldest.index);
    }
}

Result<std::shared_ptr<const LightMapStrip>> LightMapSource::band(int index) {
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
        if (fireflies_.limit > 0)
            if (auto settled = formats::checkFireflies(*band, fireflies_.limit, fireflies_.repair, fireflies_.file); !settled)
                return tl::make_unexpected(settled.error());
        slot->band = std::make_shared<const LightMapStrip>(std::move(*band));
    }
    owner_.keep(*this, index, kBytesPerTexel * static_cast<std::size_t>(width()) * static_cast<std::size_t>(bandRows(index)));
    return slot->band;
}

Result<LightMapStrip> LightMapSource::stripWithMargin(int index, int above, int below) {
    const int first = std::max(0, stripFirstRow(index) - above);
    const int end = std::min(height(), stripFirstRow(index) + stripRows(index) + below);
    LightMapStrip result;
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

Result<std::vector<BakedTexel>> coveredOfBlock(LightMapSource& bake, int x, int y) {
    constexpr int kSize = 4;
    std::vector<BakedTexel> texels;
    const auto band = bake.band(y / kBandRows);
    if (!band) return tl::make_unexpected(band.error());
    const formats::LightMapStrip& rows = **band;
    for (int at = y; at < std::min(y + kSize, rows.firstRow + rows.sh.height()); ++at)
        for (int column = x; column < std::min(x + kSize, bake.width()); ++column) {
            const int row = at - rows.firstRow;
            if (rows.covered.at(column, row) != 0) texels.push_back({column, at, rows.sh.at(column, row), rows.normal.at(column, row)});
        }
    return texels;
}

Json toJson(const formats::LightMapDescription& description) {
    return {{"bake", description.bake},
            {"phase", formats::conventionName(description.phase)},
            {"frame", formats::conventionName(description.frame)},
            {"quantity", formats::conventionName(description.quantity)},
            {"light_units", formats::conventionName(description.lightUnits)},
            {"color_source", description.colors.source},
            {"color_working", description.colors.working},
            {"firefly_limit", description.fireflyLimit},
            {"repair", description.repair}};
}

formats::ColorSpaces colorSpacesOf(const std::string& source, const std::string& working, const Action& action) {
    const auto config = action.inputs.find(kColorConfigRole);
    return {source, working, config == action.inputs.end() ? std::filesystem::path() : config->second};
}

namespace {

/// The inverse of toJson.
Result<formats::LightMapDescription> lightMapDescriptionFromJson(const Json& json, const Action& action) {
    try {
        formats::LightMapDescription description;
        description.bake = json.at("bake").get<std::string>();
        description.phase = conventionAt<formats::ShPhase>(json, "phase");
        description.frame = conventionAt<formats::ShFrame>(json, "frame");
        description.quantity = conventionAt<formats::ShQuantity>(json, "quantity");
        description.lightUnits = conventionAt<formats::LightUnits>(json, "light_units");
        description.colors = colorSpacesOf(json.at("color_source").get<std::string>(), json.at("color_working").get<std::string>(), action);
        description.fireflyLimit = json.at("firefly_limit").get<double>();
        description.repair = json.at("repair").get<bool>();
        return description;
    } catch (const std::exception& mistake) {
        return failure(ErrorCode::FileUnreadable, action.asset,
                       fmt::format("found {}, expected a light map's description", mistake.what()));
    }
}

}  // namespace

Result<LightMapSource*> openLightMap(const ActionContext& context, const Json& description) {
    const auto read = lightMapDescriptionFromJson(description, context.action);
    if (!read) return tl::make_unexpected(read.error());
    return context.lightMaps.open(context.action.inputs.at("source"), *read);
}

}  // namespace lightcook::pipeline
