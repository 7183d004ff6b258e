#include "formats/bakes/sh9.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace lightcook::formats {
namespace {

using lighting::ShRgb;

constexpr int kFloatsPerTexel = 3 * lighting::kShCount;
static_assert(sizeof(ShRgb) == kFloatsPerTexel * sizeof(float), "OpenEXR reads a texel as 27 floats in a row");
const char* const kCoverage = "coverage.Y";
const char* const kNormal[3] = {"normal.X", "normal.Y", "normal.Z"};

class Sh9Reader final : public BakeReader {
public:
    Sh9Reader(ExrReader file, bool hasNormals)
        : file_(std::move(file)), hasCoverage_(file_.info().has(kCoverage)), hasNormals_(hasNormals) {}

    int width() const override { return file_.info().width; }
    int height() const override { return file_.info().height; }
    int tileHeight() const override { return file_.info().isTiled ? file_.info().tileHeight : kTileExtent; }
    bool hasNormals() const override { return hasNormals_; }
    bool hasCoverage() const override { return hasCoverage_; }

    Result<RawStrip> read(int firstRow, int rowCount) const override {
        RawStrip raw;
        raw.sh = Image<ShRgb>(width(), rowCount);
        std::vector<ExrPlane> planes;
        float* const firstFloat = &raw.sh.texels().data()->front().x;
        for (int i = 0; i < kFloatsPerTexel; ++i)
            planes.push_back({sh9Channel(i), firstFloat + i, kFloatsPerTexel, width() * kFloatsPerTexel});
        if (hasCoverage_) {
            raw.coverage = Image<float>(width(), rowCount);
            planes.push_back({kCoverage, raw.coverage.texels().data(), 1, width()});
        }
        if (hasNormals_) {
            raw.normal = Image<glm::vec3>(width(), rowCount);
            for (int axis = 0; axis < 3; ++axis) planes.push_back({kNormal[axis], &raw.normal.texels().data()->x + axis, 3, 3 * width()});
        }
        if (const auto read = file_.readRows(firstRow, rowCount, planes); !read) return tl::make_unexpected(read.error());
        return raw;
    }

private:
    ExrReader file_;
    bool hasCoverage_ = false, hasNormals_ = false;
};

}  // namespace

std::string sh9Channel(int index) {
    return fmt::format("sh{:02}.{}", index / 3, "RGB"[index % 3]);
}

std::vector<std::string> sh9Channels() {
    std::vector<std::string> names;
    for (int index = 0; index < kFloatsPerTexel; ++index) names.push_back(sh9Channel(index));
    return names;
}

Result<std::unique_ptr<BakeReader>> openSh9(ExrReader file, const std::string& subject) {
    const auto count = std::count_if(std::begin(kNormal), std::end(kNormal), [&](const char* name) { return file.info().has(name); });
    if (count != 0 && count != 3) {
        return failure(ErrorCode::WrongShape, subject,
                       fmt::format("found {} of the channels normal.X, normal.Y, normal.Z, expected all or none", count));
    }
    return std::make_unique<Sh9Reader>(std::move(file), count == 3);
}

}  // namespace lightcook::formats
