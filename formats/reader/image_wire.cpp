// Images of OpenImageIO behind the wall: both sides of it. The reader holds the whole image, and rows of RGBA come in pieces of
// kPieceBytes.
#include <algorithm>
#include <cstring>

#include "formats/image/image_claims.h"
#include "formats/image/image_module.h"
#include "formats/memory.h"
#include "formats/reader/decoders.h"
#include "formats/reader/reader_process.h"

namespace lightcook::formats {
namespace {

constexpr std::size_t kMostIgnored = 16;
constexpr int kMostImageChannels = 1 << 16;

class ImageBehindWall : public ForeignDecoder {
public:
    explicit ImageBehindWall(const ForeignInput& input) : input_(input) {}
    Result<void> open(WireReader& /*arguments*/, WireWriter& description) override {
        LC_TRY(module, imageModule());
        (*module)->limitAvailableMemory(statedMemory());
        LC_TRY(image, (*module)->readImage(input_.path, reportProgress));
        image_ = std::move(*image);
        description.put(image_.texels.width());
        description.put(image_.texels.height());
        description.put(image_.channelCount);
        description.put(image_.hasAlpha);
        description.put(image_.ignored);
        return {};
    }
    Result<void> read(WireReader& arguments, std::span<std::byte> out) override {
        const int firstRow = arguments.get<int>(), rowCount = arguments.get<int>();
        const auto rows = image_.texels.view().rows(firstRow, rowCount);
        std::memcpy(out.data(), rows.texels, sizeof(glm::vec4) * static_cast<std::size_t>(rows.width) * static_cast<std::size_t>(rowCount));
        return {};
    }

private:
    ForeignInput input_;
    PlainImage image_;
};

Result<PlainImage> readInChild(const std::filesystem::path& file) {
    LC_TRY(descriptor, openForeignFile(file, "an image"));
    LC_TRY(reader, ReaderProcess::start(ForeignKind::Image, descriptor->number(), file));
    LC_TRY(described, reader->open({}));
    WireReader& description = **described;
    const int width = description.get<int>(), height = description.get<int>();
    PlainImage image;
    image.channelCount = description.get<int>();
    image.hasAlpha = description.get<bool>();
    image.ignored = description.texts();
    const bool isPossible = 1 <= image.channelCount && image.channelCount <= kMostImageChannels && image.ignored.size() <= kMostIgnored;
    if (!description.isWhole() || !isPossible) return reader->senseless();
    LC_CHECK(checkExtent(width, height, image.channelCount, 4, file));
    image.texels = Image<glm::vec4>(width, height);
    const std::size_t rowBytes = sizeof(glm::vec4) * static_cast<std::size_t>(width);
    const int rowsAtOnce = std::max(1, static_cast<int>(kPieceBytes / rowBytes));
    for (int row = 0; row < height; row += rowsAtOnce) {
        const int rowCount = std::min(rowsAtOnce, height - row);
        WireWriter request;
        request.put(row);
        request.put(rowCount);
        LC_TRY(bytes, reader->read(request, rowBytes * static_cast<std::size_t>(rowCount)));
        std::memcpy(image.texels.view().row(row), bytes->data(), bytes->size());
    }
    return image;
}

}  // namespace

Result<PlainImage> readImageByModule(const std::filesystem::path& file) {
    if (areReadersChildren()) return readInChild(file);
    LC_TRY(module, imageModule());
    return (*module)->readImage(file, nullptr);
}

std::unique_ptr<ForeignDecoder> decodeImageBehindWall(const ForeignInput& input) {
    return std::make_unique<ImageBehindWall>(input);
}

}  // namespace lightcook::formats
