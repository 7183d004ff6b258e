#include "pipeline/assets/light_map/source.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "formats/fireflies.h"
#include "formats/mip_reduction.h"
#include "pipeline/assets/light_map/constant_light.h"
#include "pipeline/assets/light_map/mips.h"
#include "pipeline/assets/light_map/strip_digest.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/graph/part_cache.h"

namespace lightcook::pipeline {
namespace {

using formats::LightMapStrip;
using formats::Result;

std::size_t bytesOfStrip(const LightMapStrip& strip) {
    const auto bytes = [](const auto& image) { return image.texels().size() * sizeof(image.texels().front()); };
    return bytes(strip.sh) + bytes(strip.covered) + bytes(strip.normal) + bytes(strip.tangent) + bytes(strip.chart);
}

/// Returns what tells apart a file from one that was written to its place later, as a cook may do with a packed bake.
std::string stampOf(const std::filesystem::path& file) {
    std::error_code code;
    const auto written = std::filesystem::last_write_time(file, code);
    return fmt::format("{} {}", written.time_since_epoch().count(), std::filesystem::file_size(file, code));
}

/// Returns the role of a file that is read beside the source.
std::string roleOfPart(std::string_view name) {
    return fmt::format("{}-{}", kSourceRole, name);
}

template <class T>
void copyRows(formats::ImageView<const T> source, int sourceRow, formats::ImageView<T> out, int outRow, int count) {
    for (int y = 0; y < count; ++y) std::copy_n(source.row(sourceRow + y), source.width, out.row(outRow + y));
}

}  // namespace

Result<LightMapSource*> LightMapSources::open(const std::filesystem::path& file, const formats::LightMapDescription& description) {
    std::string key =
        std::filesystem::absolute(file).lexically_normal().string() + toJson(description).dump() + description.colors.config.string();
    for (const auto& [name, part] : description.partFiles) key += fmt::format("\n{} {}", name, part.string());
    key += fmt::format("\n{}\n{}\n{}", description.mesh.string(), description.lmbake.string(), stampOf(file));
    const std::lock_guard lock(mutex_);
    if (const auto known = sources_.find(key); known != sources_.end()) return known->second.get();
    LC_TRY(reader, formats::LightMapReader::open(file, description));
    std::unique_ptr<LightMapSource> source(
        new LightMapSource(*this, std::make_shared<const formats::LightMapReader>(std::move(*reader)), description));
    if (description.constantOf) LC_CHECK(source->makeConstant(*description.constantOf, file));
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
    while (keptBytes_ > kKeptBytes && kept_.size() > kLeastKept) {
        const Kept oldest = kept_.front();
        kept_.pop_front();
        keptBytes_ -= oldest.bytes;
        const std::lock_guard sourceLock(oldest.source->mutex_);
        oldest.source->slots_.erase(oldest.index);
    }
}

Result<void> LightMapSource::makeConstant(const glm::ivec2& size, const std::filesystem::path& file) {
    if (size != glm::ivec2(reader_->width(), reader_->height()))
        return formats::failure(
            formats::ErrorCode::Verification, file,
            fmt::format("found {} x {} texels, expected {} x {} as cooked", reader_->width(), reader_->height(), size.x, size.y));
    ConstantLight light;
    auto strip = std::make_shared<LightMapStrip>();
    for (int index = 0; index < chunkCount(); ++index) {
        LC_TRY(rows, readChunk(index));
        light.add(*rows);
        strip->repairs += rows->repairs;
        strip->negativeAfterGamut += rows->negativeAfterGamut;
    }
    if (!light.isConstant())
        return formats::failure(
            formats::ErrorCode::Verification, file,
            "found texels of different light, expected one light everywhere, as when it was cooked: cook the scene again");
    strip->sh = formats::Image<lighting::ShRgb>(kConstantSide, kConstantSide);
    strip->covered = formats::Image<std::uint8_t>(kConstantSide, kConstantSide);
    strip->normal = formats::Image<glm::vec3>(kConstantSide, kConstantSide);
    std::ranges::fill(strip->sh.texels(), light.sh());
    std::ranges::fill(strip->covered.texels(), std::uint8_t{1});
    std::ranges::fill(strip->normal.texels(), light.normal());
    constant_ = std::move(strip);
    constantTexels_ = light.texels();
    return {};
}

// Surveys do not run under the lock: they run on several threads, which may turn to another action of this map.
Result<std::shared_ptr<const MapSurvey>> LightMapSource::survey(const ActionContext& context, bool hasSharedExit) {
    {
        const std::lock_guard lock(surveyMutex_);
        if (survey_ && (survey_->hasSharedExit() || !hasSharedExit)) return survey_;
    }
    LC_TRY(survey, surveyMap(*this, hasSharedExit, context));
    const std::lock_guard lock(surveyMutex_);
    if (!survey_ || hasSharedExit) survey_ = std::make_shared<const MapSurvey>(std::move(*survey));
    return survey_;
}

Result<const MipSurvey*> LightMapSource::mipSurvey(const ActionContext& context) {
    {
        const std::lock_guard lock(surveyMutex_);
        if (mipSurvey_) return mipSurvey_.get();
    }
    LC_TRY(survey, surveyMips(*this, context));
    const std::lock_guard lock(surveyMutex_);
    if (!mipSurvey_) mipSurvey_ = std::make_shared<const MipSurvey>(std::move(*survey));
    return mipSurvey_.get();
}

LightMapSource& LightMapSource::mip(int level) {
    const std::lock_guard lock(surveyMutex_);
    std::unique_ptr<LightMapSource>& mip = mips_[level];
    if (!mip) {
        mip.reset(new LightMapSource(*this, level));
        mip->mipSurvey_ = mipSurvey_;
    }
    return *mip;
}

Result<LightMapStrip> LightMapSource::reduceChunk(int index) const {
    const int firstRow = index * kChunkRows, rowCount = chunkRows(index);
    formats::MipReduction reduction(width(), firstRow, rowCount, level_);
    const int last = (((firstRow + rowCount) << level_) - 1) / kChunkRows;
    for (int baseIndex = (firstRow << level_) / kChunkRows; baseIndex <= last; ++baseIndex) {
        LC_TRY(chunk, base_->chunk(baseIndex));
        reduction.add(**chunk);
    }
    LightMapStrip strip = reduction.finish();
    strip.chart = chartsOfMip(*mipSurvey_, level_, width(), firstRow, rowCount);
    return strip;
}

Result<LightMapStrip> LightMapSource::readChunk(int index) const {
    if (base_ != nullptr) return reduceChunk(index);
    auto chunk = reader_->read(index * kChunkRows, chunkRows(index));
    if (!chunk || !(description_.fireflyLimit > 0)) return chunk;
    const auto placeOf = [this](const formats::Firefly& firefly) { return reader_->placeOf(0, firefly.colour, firefly.x, firefly.y); };
    LC_CHECK(formats::checkFireflies(*chunk, description_.fireflyLimit, description_.repair, placeOf));
    return chunk;
}

Result<std::shared_ptr<const LightMapStrip>> LightMapSource::chunk(int index) {
    if (constant_) return constant_;
    std::shared_ptr<Slot> slot;
    {
        const std::lock_guard lock(mutex_);
        auto& entry = slots_[index];
        if (!entry) entry = std::make_shared<Slot>();
        slot = entry;
    }
    const std::lock_guard lock(slot->mutex);  // two threads that ask for one chunk decode it once
    if (!slot->chunk) {
        LC_TRY(chunk, readChunk(index));
        slot->chunk = std::make_shared<const LightMapStrip>(std::move(*chunk));
    }
    owner_.keep(*this, index, bytesOfStrip(*slot->chunk));
    return slot->chunk;
}

Result<std::string> LightMapSource::storedDigest(int index) {
    if (constant_ || base_ != nullptr) return std::string();
    LC_TRY(stored, reader_->storedDigest(index * kChunkRows, chunkRows(index)));
    if (stored->empty()) return stored;
    const std::lock_guard lock(digestMutex_);
    if (!conventions_) {
        std::vector<std::string> all = {toJson(description_).dump(), std::string(reader_->bake())};
        all.push_back(description_.isCompressed ? "compressed" : "");
        auto files = sourceInputs({}, description_.colors);
        if (!description_.mesh.empty())
            files.merge(meshInputs(kFramesRole, description_.mesh, description_.lmbake, formats::GltfFiles::Geometry));
        for (const auto& [role, file] : files) {
            if (role == kSourceRole) continue;
            if (const auto digest = digestOfFile(file)) all.push_back(role + *digest);  // a mesh that is not there is not read
        }
        conventions_ = digestOf(all);
    }
    return digestOf(*conventions_, index, width(), height(), *stored);
}

Result<std::shared_ptr<const LightMapSource::ChunkDigests>> LightMapSource::digestsOf(int index, const PartCache& parts) {
    {
        const std::lock_guard lock(digestMutex_);
        if (const auto known = digests_.find(index); known != digests_.end()) return known->second;
    }
    LC_TRY(stored, storedDigest(index));
    const auto make = [&]() -> Result<ChunkDigests> {
        LC_TRY(strip, chunk(index));
        ChunkDigests made;
        for (int y = 0; y < (*strip)->sh.height(); ++y) made.rows.push_back(digestOfRow(**strip, y));
        made.rest = digestOf((*strip)->repairs, (*strip)->coverage, (*strip)->negativeAfterGamut);
        return made;
    };
    LC_TRY(made, cachedPart(
                     stored->empty() ? nullptr : &parts, [&] { return Result<std::string>(digestOf("rows", *stored)); }, make));
    auto shared = std::make_shared<const ChunkDigests>(std::move(*made));
    const std::lock_guard lock(digestMutex_);
    digests_.emplace(index, shared);
    return shared;
}

std::pair<int, int> LightMapSource::rowsOfStrip(int index, int above, int below) const {
    const int first = stripFirstRow(index);
    return {std::max(0, first - above), std::min(height(), first + stripRows(index) + below)};
}

Result<std::string> LightMapSource::digestOfStrip(int index, int above, int below, const PartCache& parts) {
    const auto [first, end] = rowsOfStrip(index, above, below);
    std::vector<std::string> rows;
    for (int row = first; row < end; ++row) {
        LC_TRY(digests, digestsOf(row / kChunkRows, parts));
        rows.push_back((*digests)->rows[static_cast<std::size_t>(row % kChunkRows)]);
    }
    return digestOf(first, rows);
}

Result<std::string> LightMapSource::digestOfChunk(int index, const PartCache& parts) {
    LC_TRY(digests, digestsOf(index, parts));
    return digestOf(index * kChunkRows, **digests);
}

Result<LightMapStrip> LightMapSource::stripWithMargin(int index, int above, int below) {
    const auto [first, end] = rowsOfStrip(index, above, below);
    return rows(first, end - first);
}

Result<LightMapStrip> LightMapSource::rows(int firstRow, int rowCount) {
    const int end = firstRow + rowCount;
    LightMapStrip result;
    result.firstRow = firstRow;
    result.sh = formats::Image<lighting::ShRgb>(width(), rowCount);
    result.covered = formats::Image<std::uint8_t>(width(), rowCount);
    result.normal = formats::Image<glm::vec3>(width(), rowCount);
    for (int row = firstRow; row < end;) {
        LC_TRY(source, chunk(row / kChunkRows));
        const int sourceRow = row - (*source)->firstRow;
        const int count = std::min((*source)->sh.height() - sourceRow, end - row);
        copyRows((*source)->sh.view(), sourceRow, result.sh.view(), row - firstRow, count);
        copyRows((*source)->covered.view(), sourceRow, result.covered.view(), row - firstRow, count);
        copyRows((*source)->normal.view(), sourceRow, result.normal.view(), row - firstRow, count);
        if ((*source)->tangent.width() > 0) {
            if (result.tangent.width() == 0) result.tangent = formats::Image<glm::vec4>(width(), rowCount);
            copyRows((*source)->tangent.view(), sourceRow, result.tangent.view(), row - firstRow, count);
        }
        if ((*source)->chart.width() > 0) {
            if (result.chart.width() == 0) result.chart = formats::Image<std::uint32_t>(width(), rowCount);
            copyRows((*source)->chart.view(), sourceRow, result.chart.view(), row - firstRow, count);
        }
        row += count;
    }
    return result;
}

Result<std::vector<BakedTexel>> coveredOfBlock(LightMapSource& bake, int x, int y) {
    constexpr int kSize = 4;
    std::vector<BakedTexel> texels;
    LC_TRY(chunk, bake.chunk(y / kChunkRows));
    const formats::LightMapStrip& rows = **chunk;
    for (int at = y; at < std::min(y + kSize, rows.firstRow + rows.sh.height()); ++at)
        for (int column = x; column < std::min(x + kSize, bake.width()); ++column) {
            const int row = at - rows.firstRow;
            if (rows.covered.at(column, row) != 0) texels.push_back({column, at, rows.sh.at(column, row), rows.normal.at(column, row)});
        }
    return texels;
}

std::vector<int> spreadStrips(const LightMapSource& source, std::int64_t most) {
    const std::int64_t texels = static_cast<std::int64_t>(source.width()) * source.height();
    const int step = static_cast<int>(std::max<std::int64_t>(1, texels / most + (texels % most != 0 ? 1 : 0)));
    std::vector<int> strips;
    for (int strip = (step - 1) / 2; strip < source.stripCount(); strip += step) strips.push_back(strip);
    return strips;
}

Result<formats::LightMapDescription> descriptionOf(const CookedAsset& asset) {
    return fromJson<formats::LightMapDescription>(asset.source.description.value_or(Json()), asset.name + ", source/description");
}

std::map<std::string, std::filesystem::path> bakeInputs(const std::filesystem::path& file,
                                                        const formats::LightMapDescription& description) {
    std::map<std::string, std::filesystem::path> inputs = sourceInputs(file, description.colors);
    for (const auto& [name, part] : description.partFiles) inputs[roleOfPart(name)] = part;
    if (description.parts.empty())
        for (const std::filesystem::path& beside : formats::bakeFilesBeside(file, description.bake))
            inputs[roleOfPart(beside.filename().string())] = beside;
    if (!description.lmbake.empty()) inputs[kLmbakeRole] = description.lmbake;
    if (!formats::readsMesh(file, description)) return inputs;
    inputs.merge(meshInputs(kFramesRole, description.mesh, {}, formats::GltfFiles::Geometry));
    return inputs;
}

formats::LightMapDescription withFiles(formats::LightMapDescription description,
                                       const std::map<std::string, std::filesystem::path>& inputs) {
    if (const auto config = inputs.find(kColorConfigRole); config != inputs.end()) description.colors.config = config->second;
    if (const auto mesh = inputs.find(kFramesRole); mesh != inputs.end()) description.mesh = mesh->second;
    // A repacked map, which takes none, has that of the bake among its inputs.
    if (const auto lmbake = inputs.find(kLmbakeRole); lmbake != inputs.end() && formats::mayTakeLmbake(description.bake))
        description.lmbake = lmbake->second;
    for (const std::string& name : description.parts)
        if (const auto part = inputs.find(roleOfPart(name)); part != inputs.end()) description.partFiles[name] = part->second;
    return description;
}

std::uint64_t bakeBytes(const Action& action) {
    std::set<std::filesystem::path> files;  // the first image of a list has two roles
    for (const auto& [role, path] : action.inputs)
        if (role.starts_with(kSourceRole)) files.insert(path);
    std::uint64_t bytes = 0;
    for (const std::filesystem::path& file : files) bytes += std::filesystem::file_size(file);
    return bytes;
}

Result<LightMapSource*> openLightMap(const ActionContext& context, formats::LightMapDescription description) {
    return context.shared.get<LightMapSources>().open(context.action.inputs.at(kSourceRole),
                                                      withFiles(std::move(description), context.action.inputs));
}

}  // namespace lightcook::pipeline
