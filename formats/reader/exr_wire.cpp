// OpenEXR files behind the wall: both sides of it.
//
// Rows come as planes, one channel after the other, in pieces of whole chunks of the file and of about kPieceBytes. So the memory that both
// processes share is bounded, and no chunk is decoded twice.
#include <algorithm>
#include <cstring>

#include "formats/digest.h"
#include "formats/image/exr_source.h"
#include "formats/reader/decoders.h"
#include "formats/reader/reader_process.h"

namespace lightcook::formats {
namespace {

constexpr int kMostChunkRows = 1 << 22;  // of a tile that is one texel wide

void putInfo(WireWriter& out, const ExrInfo& info) {
    out.put(info.width);
    out.put(info.height);
    out.put(info.isTiled);
    out.put(info.tileHeight);
    out.put(info.channels);
    out.put(info.integerChannels);
    out.put(info.chromaticities.has_value());
    for (const float each : info.chromaticities.value_or(StatedChromaticities{})) out.put(each);
    out.put(info.environment.has_value());
    out.put(info.environment == ExrEnvironment::Cube);
}

ExrInfo getInfo(WireReader& in) {
    ExrInfo info;
    info.width = in.get<int>();
    info.height = in.get<int>();
    info.isTiled = in.get<bool>();
    info.tileHeight = in.get<int>();
    info.channels = in.texts();
    info.integerChannels = in.texts();
    const bool hasChromaticities = in.get<bool>();
    StatedChromaticities chromaticities{};
    for (float& each : chromaticities) each = in.get<float>();
    if (hasChromaticities) info.chromaticities = chromaticities;
    const bool hasEnvironment = in.get<bool>(), isCube = in.get<bool>();
    if (hasEnvironment) info.environment = isCube ? ExrEnvironment::Cube : ExrEnvironment::LatLong;
    return info;
}

/// Returns true if a file that openExrHere() takes can have it.
bool isPossible(const ExrInfo& info, int chunkRows) {
    const auto isExtent = [](int extent) { return 1 <= extent && extent <= kLargestExtent; };
    const bool isTiling = info.isTiled ? info.tileHeight == chunkRows : info.tileHeight == 0;
    return isExtent(info.width) && isExtent(info.height) && isTiling && 1 <= chunkRows && chunkRows <= kMostChunkRows &&
           info.channels.size() <= kMostExrChannels && info.integerChannels.size() <= info.channels.size();
}

enum class Request : std::uint8_t { Texels, StoredDigest };

WireWriter requestOf(Request request, int firstRow, int rowCount) {
    WireWriter out;
    out.put(request);
    out.put(firstRow);
    out.put(rowCount);
    return out;
}

/// A file that a child process decodes.
class ExrOfChild : public ExrSource {
public:
    ExrOfChild(ReaderProcess reader, ExrInfo info, int chunkRows)
        : reader_(std::move(reader)), info_(std::move(info)), chunkRows_(chunkRows) {}
    const ExrInfo& info() const override { return info_; }
    int chunkRows() const override { return chunkRows_; }
    Result<void> readRows(int firstRow, int rowCount, std::span<const ExrPlane> planes) override {
        const std::size_t rowBytes = planes.size() * sizeof(float) * static_cast<std::size_t>(info_.width);
        const int chunksAtOnce = std::max(1, static_cast<int>(kPieceBytes / rowBytes) / chunkRows_);
        for (int row = firstRow; row < firstRow + rowCount;) {
            const std::int64_t chunkEnd = (std::int64_t{row / chunkRows_} + chunksAtOnce) * chunkRows_;
            const int end = static_cast<int>(std::min<std::int64_t>(firstRow + rowCount, chunkEnd));
            WireWriter request = requestOf(Request::Texels, row, end - row);
            request.put(static_cast<std::uint32_t>(planes.size()));
            for (const ExrPlane& plane : planes) request.put(std::string_view(plane.channel));
            LC_TRY(bytes, reader_.read(request, rowBytes * static_cast<std::size_t>(end - row)));
            copy(bytes->data(), row - firstRow, end - row, planes);
            row = end;
        }
        return {};
    }

    Result<std::string> storedDigest(int firstRow, int rowCount) override {
        LC_TRY(bytes, reader_.read(requestOf(Request::StoredDigest, firstRow, rowCount), kDigestLength));
        const char* const text = reinterpret_cast<const char*>(bytes->data());
        return std::string(text, *text == '\0' ? 0 : bytes->size());
    }

private:
    /// Copies some texels of every plane in turn, since the planes of a light map interleave.
    void copy(const std::byte* from, int firstRow, int rowCount, std::span<const ExrPlane> planes) const {
        constexpr int kTexelsAtOnce = 64;
        const auto texelOf = [&](std::size_t plane, int row, int x) {
            return from + ((std::ptrdiff_t(plane) * rowCount + row) * info_.width + x) * std::ptrdiff_t{sizeof(float)};
        };
        for (int row = 0; row < rowCount; ++row)
            for (int first = 0; first < info_.width; first += kTexelsAtOnce)
                for (std::size_t i = 0; i < planes.size(); ++i) {
                    const ExrPlane& plane = planes[i];
                    float* to = plane.texels + (firstRow + row) * plane.rowStride + first * plane.texelStride;
                    const std::byte* texel = texelOf(i, row, first);
                    for (int x = first; x < std::min(first + kTexelsAtOnce, info_.width); ++x) {
                        std::memcpy(to, texel, sizeof(float));
                        to += plane.texelStride;
                        texel += sizeof(float);
                    }
                }
    }

    ReaderProcess reader_;
    ExrInfo info_;
    int chunkRows_;
};

class ExrBehindWall : public ForeignDecoder {
public:
    explicit ExrBehindWall(const ForeignInput& input) : input_(input) {}
    Result<void> open(WireReader& /*arguments*/, WireWriter& description) override {
        LC_TRY(source, openExrHere(input_.descriptor, input_.path));
        source_ = std::move(*source);
        putInfo(description, source_->info());
        description.put(source_->chunkRows());
        return {};
    }
    Result<void> read(WireReader& arguments, std::span<std::byte> out) override {
        const auto request = arguments.get<Request>();
        const int firstRow = arguments.get<int>(), rowCount = arguments.get<int>();
        if (request == Request::StoredDigest) {
            LC_TRY(digest, source_->storedDigest(firstRow, rowCount));
            std::ranges::fill(out, std::byte{0});
            std::ranges::copy(std::as_bytes(std::span(*digest)), out.begin());
            return {};
        }
        const auto planeSize = std::ptrdiff_t{source_->info().width} * rowCount;
        std::vector<ExrPlane> planes;
        for (std::string& channel : arguments.texts())
            planes.push_back(
                {std::move(channel), reinterpret_cast<float*>(out.data()) + std::ssize(planes) * planeSize, 1, source_->info().width});
        return source_->readRows(firstRow, rowCount, planes);
    }

private:
    ForeignInput input_;
    std::unique_ptr<ExrSource> source_;
};

}  // namespace

Result<std::unique_ptr<ExrSource>> openExrInChild(int descriptor, const std::filesystem::path& file) {
    LC_CHECK(checkExrVersion(descriptor, file));  // most files that are opened and are no OpenEXR end here
    LC_TRY(reader, ReaderProcess::start(ForeignKind::Exr, descriptor, file));
    LC_TRY(description, reader->open({}));
    ExrInfo info = getInfo(**description);
    const int chunkRows = (*description)->get<int>();
    if (!(*description)->isWhole() || !isPossible(info, chunkRows)) return reader->senseless();
    return std::make_unique<ExrOfChild>(std::move(*reader), std::move(info), chunkRows);
}

std::unique_ptr<ForeignDecoder> decodeExrBehindWall(const ForeignInput& input) {
    return std::make_unique<ExrBehindWall>(input);
}

}  // namespace lightcook::formats
