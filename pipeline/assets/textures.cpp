#include "pipeline/assets/textures.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::PixelFormat;
using formats::Result;

/// Rows of blocks that one task encodes: small enough to spread a 256 x 256 texture over a few threads.
constexpr int kBlockRowsPerTask = 8;

Result<formats::TextureWriter> createTexture(const std::filesystem::path& file, const formats::TextureShape& shape,
                                             const TextureSettings& settings, const std::map<std::string, std::string>& metadata) {
    formats::TextureFileOptions options;
    options.container = settings.container;
    options.zstd = settings.zstd;
    options.metadata = metadata;
    return formats::TextureWriter::create(file, shape, options);
}

Result<void> writeImages(formats::TextureWriter& writer, const formats::TextureShape& shape,
                         const std::vector<std::vector<std::byte>>& images) {
    std::size_t index = 0;
    for (int mip = 0; mip < shape.mipCount; ++mip)
        for (int layer = 0; layer < shape.layerCount; ++layer)
            for (int face = 0; face < shape.faceCount; ++face) LC_CHECK(writer.writeBlockRows({mip, layer, face}, 0, images.at(index++)));
    return {};
}

/// Returns the manifest entry of a texture file; its digest follows when the manifest is put together.
CookedTexture entryOf(const TexturePlan& plan, const std::string& file, std::uint64_t fileBytes, std::string_view filter) {
    CookedTexture entry;
    entry.role = plan.role;
    entry.file = file;
    entry.format = formats::info(plan.shape.format).name;
    entry.apiFormats = formats::apiFormats(plan.shape.format);
    entry.isArray = plan.shape.isArray;
    entry.width = plan.shape.width;
    entry.height = plan.shape.height;
    if (plan.side != 1) entry.side = plan.side;
    entry.mips = plan.shape.mipCount;
    entry.layers = plan.shape.layerCount;
    entry.faces = plan.shape.faceCount;
    entry.bytesGpu = plan.shape.gpuBytes();
    entry.bytesDisk = fileBytes;
    entry.sampler.filter = filter;
    return entry;
}

Json metadataOf(const TextureOwner& owner, const TexturePlan& plan) {
    Json members = {
        {"kind", std::string(info(owner.kind).name)}, {"layout", owner.layout}, {"role", plan.role}, {"constants", plan.constants}};
    if (owner.distribution) members["distribution"] = *owner.distribution;
    if (owner.normalization) members["normalization"] = *owner.normalization;
    return members;
}

}  // namespace

compress::EncodeOptions TextureSettings::encodeOptions() const {
    compress::EncodeOptions options;
    options.effort = effort;
    options.rdo = static_cast<float>(rdo);
    return options;
}

std::vector<std::byte> encodeImage(PixelFormat format, formats::ImageView<const glm::vec4> texels,
                                   formats::ImageView<const float> significance, const compress::EncodeOptions& options,
                                   compress::EncodeReport& report) {
    const int blockHeight = formats::info(format).blockHeight;
    const int blockRows = formats::blocksDown(format, texels.height);
    const std::size_t rowBytes = formats::bytesPerBlockRow(format, texels.width);
    std::vector<std::byte> bytes(rowBytes * static_cast<std::size_t>(blockRows));
    const int taskCount = (blockRows + kBlockRowsPerTask - 1) / kBlockRowsPerTask;
    std::vector<compress::EncodeReport> reports(static_cast<std::size_t>(taskCount));
    tbb::parallel_for(0, taskCount, [&](int task) {
        const int firstBlockRow = task * kBlockRowsPerTask;
        const int rowsOfBlocks = std::min(kBlockRowsPerTask, blockRows - firstBlockRow);
        const int firstRow = firstBlockRow * blockHeight;
        const int rowCount = std::min(rowsOfBlocks * blockHeight, texels.height - firstRow);
        const auto weights = significance.texels == nullptr ? significance : significance.rows(firstRow, rowCount);
        const std::span<std::byte> out(bytes.data() + static_cast<std::size_t>(firstBlockRow) * rowBytes,
                                       static_cast<std::size_t>(rowsOfBlocks) * rowBytes);
        reports[static_cast<std::size_t>(task)] = compress::encodeRows(format, texels.rows(firstRow, rowCount), weights, options, out, {});
    });
    for (const compress::EncodeReport& each : reports) report.add(each);
    return bytes;
}

std::vector<std::vector<std::byte>> encodeFaces(PixelFormat format, formats::ImageView<const glm::vec3> strip, float range,
                                                const compress::EncodeOptions& options, compress::EncodeReport& report) {
    std::vector<std::vector<std::byte>> faces;
    for (int face = 0; face < 6; ++face) {
        formats::Image<glm::vec4> rgba = toRgba(strip.rows(face * strip.width, strip.width));
        for (glm::vec4& texel : rgba.texels()) texel /= range;
        faces.push_back(encodeImage(format, rgba.view(), {}, options, report));
    }
    return faces;
}

std::map<std::string, std::string> textureMetadata(const Json& members) {
    return {{kMetadataKey, members.dump()}};
}

Result<void> writeTexture(const std::filesystem::path& file, const formats::TextureShape& shape, const TextureSettings& settings,
                          const std::map<std::string, std::string>& metadata, const std::vector<std::vector<std::byte>>& images) {
    LC_TRY(writer, createTexture(file, shape, settings, metadata));
    LC_CHECK(writeImages(*writer, shape, images));
    return writer->commit();
}

Result<std::size_t> AssetTextures::create(TexturePlan plan) {
    std::string file = plan.fileName + std::string(settings_.extension());
    LC_TRY(writer, createTexture(context_.folder / file, plan.shape, settings_, textureMetadata(metadataOf(owner_, plan))));
    outputs_.push_back({std::move(plan), std::move(file), std::move(*writer)});
    return outputs_.size() - 1;
}

Result<void> AssetTextures::write(TexturePlan plan, const std::vector<std::vector<std::byte>>& images) {
    LC_TRY(index, create(std::move(plan)));
    Output& output = outputs_[*index];
    return writeImages(output.writer, output.plan.shape, images);
}

Result<ActionOutcome> AssetTextures::finish(CookResult result) {
    std::vector<std::string> files;
    for (Output& output : outputs_) {
        LC_CHECK(output.writer.commit());
        files.push_back(output.file);
        result.asset.textures.push_back(entryOf(output.plan, output.file, std::filesystem::file_size(context_.folder / output.file),
                                                output.plan.filter.empty() ? info(result.asset.kind).filter : output.plan.filter));
    }
    return outcomeWith(result, std::move(files));
}

Result<formats::TextureReader> openTexture(const std::filesystem::path& folder, const CookedAsset& asset, const std::string& role) {
    const auto entry = std::ranges::find(asset.textures, role, &CookedTexture::role);
    if (entry == asset.textures.end())
        return failure(ErrorCode::Verification, asset.name, fmt::format("found no texture '{}' in the manifest, expected one", role));
    const std::filesystem::path file = folder / entry->file;
    LC_TRY(reader, formats::TextureReader::open(file));
    const formats::TextureShape& shape = reader->shape();
    const auto disagree = [&](const char* member, const auto& found, const auto& expected) {
        return failure(ErrorCode::Verification, file, fmt::format("found {} {}, expected {} as in the manifest", member, found, expected));
    };
    if (const auto format = formats::info(shape.format).name; format != entry->format) return disagree("format", format, entry->format);
    const std::initializer_list<std::tuple<const char*, int, int>> sizes = {{"width", shape.width, entry->width},
                                                                            {"height", shape.height, entry->height},
                                                                            {"mips", shape.mipCount, entry->mips},
                                                                            {"layers", shape.layerCount, entry->layers},
                                                                            {"faces", shape.faceCount, entry->faces}};
    for (const auto& [member, found, expected] : sizes)
        if (found != expected) return disagree(member, found, expected);
    return reader;
}

float hdrRange(float largest) {
    return largest > 0 ? std::exp2(std::max(std::ceil(std::log2(largest)) - 10.0f, -120.0f)) : 1.0f;
}

formats::Image<glm::vec4> toRgba(formats::ImageView<const glm::vec3> image) {
    formats::Image<glm::vec4> rgba(image.width, image.height);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) rgba.at(x, y) = glm::vec4(image.at(x, y), 1.0f);
    return rgba;
}

}  // namespace lightcook::pipeline
