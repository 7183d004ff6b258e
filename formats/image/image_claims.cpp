#include "formats/image/image_claims.h"

#include "formats/file/file_kind.h"
#include "formats/gpu_texture.h"

namespace lightcook::formats {

Result<void> checkClaims(const std::filesystem::path& file, const Result<ExrReader>& reader) {
    if (const auto found = whyNoFile(file))
        return failure(ErrorCode::FileUnreadable, file, fmt::format("found {}, expected an image", *found));
    if (!reader && (reader.error().code == ErrorCode::WrongShape || isExrFile(file))) return tl::make_unexpected(reader.error());
    if (!reader && containerOfContent(file) == Container::Ktx2) return tl::make_unexpected(*textureForImage(file, "an image"));
    return {};
}

}  // namespace lightcook::formats
