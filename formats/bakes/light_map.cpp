#include "formats/light_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include "formats/bakes/bake_reader.h"
#include "formats/bakes/canonical.h"
#include "formats/bakes/coefficient_files.h"
#include "formats/bakes/lit_coverage.h"
#include "formats/bakes/surface_channels.h"
#include "formats/bakes/surface_frames.h"
#include "formats/bakes/unreal.h"
#include "formats/epic_light_maps.h"
#include "formats/lmbake.h"
#include "formats/plain_image.h"

namespace lightcook::formats {
namespace {

/// A bake whose format is known, and the function that opens its reader.
struct OpenBake {
    BakeRecognition recognition;
    std::function<Result<std::unique_ptr<BakeReader>>()> open;
    std::optional<StatedChromaticities> chromaticities = {};  ///< of the first file, where it states them
};

/// named  may be any file of a bake of several
Result<OpenBake> openImage(const std::filesystem::path& named, const LightMapDescription& description) {
    const std::filesystem::path file = leadingFile(named, description.bake);
    Result<BakeImage> opened = BakeImage::openAs(file, description.encoding);
    if (!opened && opened.error().code == ErrorCode::FormatUnsupported && isPictureFile(file))
        if (const std::string fault = faultOfPictureSet(file, description.bake); !fault.empty())
            return failure(ErrorCode::WrongShape, file, fault);
    if (!opened) return tl::make_unexpected(opened.error());
    const auto image = std::make_shared<BakeImage>(std::move(*opened));
    Result<BakeRecognition> recognition = findBakeFormat(description.bake, file, image->info());
    if (!recognition) return tl::make_unexpected(recognition.error());
    const BakeFormatInfo* const format = recognition->format;
    OpenBake bake{std::move(*recognition), [format, image] { return format->open(std::move(*image)); }, image->info().chromaticities};
    if (format->needsMesh())
        bake.open = [format, image, surface = BakeSurface{description.mesh, description.axes, description.places}] {
            return format->openOnMesh(std::move(*image), surface);
        };
    return bake;
}

Result<OpenBake> openGltf(const std::filesystem::path& file, const LightMapDescription& description) {
    const Result<ExrInfo> content = unrealContent(file);
    if (!content) return tl::make_unexpected(content.error());
    Result<BakeRecognition> recognition = findBakeFormat(description.bake, file, *content);
    if (!recognition) return tl::make_unexpected(recognition.error());
    const BakeFormatInfo* const format = recognition->format;
    return OpenBake{std::move(*recognition), [format, file, image = description.image] { return format->openGltf(file, image); }};
}

/// Opens a bake whose images the scene lists.
Result<OpenBake> openParts(const LightMapDescription& description, const Subject& subject) {
    const Result<const BakeFormatInfo*> format = bakeFormatOfFiles(description.parts, subject.at("files"));
    if (!format) return tl::make_unexpected(format.error());
    BakeRecognition recognition;
    recognition.format = *format;
    recognition.evidence = fmt::format("the {} images that the scene lists for {}", description.parts.size(), (*format)->content);
    recognition.isCertain = true;
    OpenBake bake{std::move(recognition), [&description] { return openCoefficientFiles(description.partFiles); }};
    if (!description.partFiles.empty())
        if (const auto first = ExrReader::open(description.partFiles.begin()->second)) bake.chromaticities = first->info().chromaticities;
    return bake;
}

Result<OpenBake> openBake(const std::filesystem::path& file, const LightMapDescription& description) {
    if (!description.parts.empty()) return openParts(description, file);
    return isGltfFile(file) ? openGltf(file, description) : openImage(file, description);
}

/// A bake that takes from a mesh what its file does not have: normals, and coverage and tangents if the description says so.
class OnMesh : public BakeReader {
public:
    OnMesh(std::unique_ptr<BakeReader> bake, SurfaceFrames frames, bool takesCoverage, bool takesTangents)
        : bake_(std::move(bake)), frames_(std::move(frames)), takesCoverage_(takesCoverage), takesTangents_(takesTangents) {}
    int width() const override { return bake_->width(); }
    int height() const override { return bake_->height(); }
    int tileHeight() const override { return bake_->tileHeight(); }
    bool hasNormals() const override { return true; }
    bool hasCoverage() const override { return takesCoverage_ || bake_->hasCoverage(); }
    std::string coverageChannel() const override { return bake_->coverageChannel(); }
    Result<std::string> storedDigest(int firstRow, int rowCount) const override { return bake_->storedDigest(firstRow, rowCount); }
    Result<RawStrip> read(int firstRow, int rowCount) const override {
        Result<RawStrip> raw = bake_->read(firstRow, rowCount);
        if (!raw) return raw;
        // UVs are rounded: a triangle that only touches a texel does not cover it.
        constexpr double kMargin = 1.0 / 64;
        const int first = std::max(firstRow - kReach, 0), end = std::min(firstRow + rowCount + kReach, height());
        const Image<SurfaceFrame> frames = frames_.rows(first, end - first, kMargin);
        const bool takesNormals = takesTangents_ || raw->normal.width() == 0;
        if (takesCoverage_) raw->coverage = Image<float>(width(), rowCount);
        if (takesNormals) raw->normal = Image<glm::vec3>(width(), rowCount);
        if (takesTangents_) raw->tangent = Image<glm::vec4>(width(), rowCount, glm::vec4(1, 0, 0, 1));
        for (int y = 0; y < rowCount; ++y)
            for (int x = 0; x < width(); ++x) {
                SurfaceFrame frame = frames.at(x, firstRow + y - first);
                if (takesCoverage_) raw->coverage.at(x, y) = frame.isSurface() ? 1.0f : 0.0f;
                if (!takesNormals) continue;
                const bool isCovered = raw->coverage.width() == 0 || raw->coverage.at(x, y) > 0.5f;
                if (!frame.isSurface() && isCovered) frame = frameNear(frames, {x, firstRow + y - first});
                raw->normal.at(x, y) = frame.normal;
                if (takesTangents_ && frame.isSurface()) raw->tangent.at(x, y) = tangentOf(frame);
            }
        return raw;
    }

    std::optional<StoredNumber> placeOf(std::size_t coefficient, int colour, int x, int y) const override {
        return bake_->placeOf(coefficient, colour, x, y);
    }

private:
    /// Bakers let light grow over the rims of charts, by a few texels.
    static constexpr int kReach = 4;

    static glm::vec4 tangentOf(const SurfaceFrame& frame) {
        const float side = glm::dot(glm::cross(frame.normal, frame.tangent), frame.bitangent);
        return glm::vec4(frame.tangent, side < 0 ? -1.0f : 1.0f);
    }
    /// Returns the frame of the surface nearest to a texel that is covered and lies on none; far from all, that of the axes.
    static SurfaceFrame frameNear(const Image<SurfaceFrame>& frames, const glm::ivec2& texel) {
        SurfaceFrame found{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        int nearest = (kReach + 1) * (kReach + 1);
        for (int y = std::max(texel.y - kReach, 0); y <= std::min(texel.y + kReach, frames.height() - 1); ++y)
            for (int x = std::max(texel.x - kReach, 0); x <= std::min(texel.x + kReach, frames.width() - 1); ++x) {
                const glm::ivec2 offset = glm::ivec2(x, y) - texel;
                const int distance = offset.x * offset.x + offset.y * offset.y;
                if (distance >= nearest || !frames.at(x, y).isSurface()) continue;
                nearest = distance;
                found = frames.at(x, y);
            }
        return found;
    }

    std::unique_ptr<BakeReader> bake_;
    SurfaceFrames frames_;
    bool takesCoverage_, takesTangents_;
};

/// Fails for an lmbake whose meshes lie in other slices than those of the map: it is that of another bake.
Result<void> checkSlices(const std::filesystem::path& lmbake, const BakeReader& reader, const Subject& subject) {
    if (lmbake.empty()) return {};
    LC_TRY(places, readLmbake(lmbake));
    const int found = places->sliceCount();
    const std::optional<int> slices = reader.sliceCount();
    if (found == 0) return failure(ErrorCode::WrongShape, lmbake, "found no mesh in it, expected those of a bake");
    if (slices ? found == *slices : reader.height() % found == 0) return {};
    return failure(ErrorCode::WrongShape, lmbake,
                   fmt::format("found meshes in {} slices, expected {}, as {} has: the lmbake of the same bake. Several files of one bake "
                               "are not read as one",
                               found, slices ? std::to_string(*slices) : "a divisor of the height", subject.text));
}

/// Fails for a directional bake of Godot 4.0 to 4.3, by the lmbake that the description names, or else by that of the map's name.
Result<void> checkDirections(const std::filesystem::path& file, const LightMapDescription& description, const BakeFormatInfo& format) {
    if (!format.takesLmbake || !format.hasDirections) return {};
    std::filesystem::path lmbake = description.lmbake;
    if (lmbake.empty()) lmbake = std::filesystem::path(file).replace_extension(".lmbake");
    std::error_code code;
    if (!std::filesystem::is_regular_file(lmbake, code)) return {};
    const auto places = readLmbake(lmbake);  // where it is needed, its errors are reported
    if (!places || !places->hasOldDirections()) return {};
    return failure(ErrorCode::FormatUnsupported, lmbake,
                   fmt::format("found a directional bake without _uses_packed_directional, as Godot 4.0 to 4.3 writes it, expected one of "
                               "Godot 4.4 or later: bake {} again with it",
                               file.filename().string()));
}

/// Returns true if an EXR file has normals. Remembers the answer while the file stays as it is: every action of a light map asks.
bool hasNormalChannels(const std::filesystem::path& file) {
    struct Answer {
        std::filesystem::file_time_type written;
        std::uintmax_t bytes = 0;
        bool hasNormals = false;
    };
    static std::mutex mutex;
    static std::map<std::filesystem::path, Answer> answers;
    std::error_code code;
    const std::uintmax_t bytes = std::filesystem::file_size(file, code);
    if (code) return false;
    const auto written = std::filesystem::last_write_time(file, code);
    if (code) return false;
    {
        const std::lock_guard lock(mutex);
        const auto known = answers.find(file);
        if (known != answers.end() && known->second.written == written && known->second.bytes == bytes) return known->second.hasNormals;
    }
    const Result<ExrReader> exr = ExrReader::open(file);
    if (!exr) return false;
    const bool hasNormals = exr->info().has(kNormalChannels.front());
    const std::lock_guard lock(mutex);
    answers[file] = {written, bytes, hasNormals};
    return hasNormals;
}

}  // namespace

bool readsMesh(const std::filesystem::path& file, const LightMapDescription& description) {
    if (description.mesh.empty()) return false;
    if (description.coverage == CoverageSource::Mesh || description.takesTangents || mayNeedMesh(file, description.bake)) return true;
    std::error_code code;
    return std::filesystem::exists(description.mesh, code) && !hasNormalChannels(leadingFile(file, description.bake));
}

struct LightMapReader::State {
    BakeRecognition recognition;
    std::unique_ptr<BakeReader> reader;
    glm::vec3 luminanceWeights{0};
    glm::dmat3 bt2020FromWorking;
    std::optional<StatedPrimaries> primaries;
    bool hasMeshNormals = false, hasTangents = false;
    Canonicalizer canonical;
};

LightMapRepairs& LightMapRepairs::operator+=(const LightMapRepairs& other) {
    notFinite += other.notFinite;
    negativeDc += other.negativeDc;
    bandsBeyond += other.bandsBeyond;
    fireflies += other.fireflies;
    return *this;
}

LightMapCoverage& LightMapCoverage::operator+=(const LightMapCoverage& other) {
    inside += other.inside;
    withoutNormal += other.withoutNormal;
    oddNormals += other.oddNormals;
    encodedNormals += other.encodedNormals;
    smallest = std::min(smallest, other.smallest);
    largest = std::max(largest, other.largest);
    return *this;
}

LightMapReader::LightMapReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
LightMapReader::LightMapReader(LightMapReader&&) noexcept = default;
LightMapReader& LightMapReader::operator=(LightMapReader&&) noexcept = default;
LightMapReader::~LightMapReader() = default;

int LightMapReader::width() const {
    return state_->reader->width();
}
int LightMapReader::height() const {
    return state_->reader->height();
}
bool LightMapReader::hasNormals() const {
    return state_->reader->hasNormals();
}
bool LightMapReader::hasMeshNormals() const {
    return state_->hasMeshNormals;
}
bool LightMapReader::hasTangents() const {
    return state_->hasTangents;
}
bool LightMapReader::hasCoverage() const {
    return state_->reader->hasCoverage();
}
bool LightMapReader::hasDirections() const {
    return state_->recognition.format->hasDirections;
}
int LightMapReader::tileHeight() const {
    return state_->reader->tileHeight();
}
glm::vec3 LightMapReader::luminanceWeights() const {
    return state_->luminanceWeights;
}
const glm::dmat3& LightMapReader::bt2020FromWorking() const {
    return state_->bt2020FromWorking;
}
const std::optional<StatedPrimaries>& LightMapReader::primaries() const {
    return state_->primaries;
}
std::string_view LightMapReader::bake() const {
    return state_->recognition.format->name;
}
const BakeRecognition& LightMapReader::recognition() const {
    return state_->recognition;
}

Result<LightMapReader> LightMapReader::open(const std::filesystem::path& file, const LightMapDescription& description) {
    const Subject subject(file);
    LC_CHECK(checkBakeName(description.bake, subject));
    Result<OpenBake> bake = openBake(file, description);
    if (!bake) return tl::make_unexpected(bake.error());
    const BakeFormatInfo& format = *bake->recognition.format;
    if (format.needsMesh() && description.mesh.empty())
        return failure(ErrorCode::InvalidRequest, subject,
                       fmt::format("found bake format {} without a mesh, expected mesh = \"FILE\" (--mesh): its light is relative to the "
                                   "surfaces that it lies on",
                                   format.name));
    LC_CHECK(checkEncoding(description.encoding, format, subject));
    LC_CHECK(checkImage(description.image, format, subject));
    LC_CHECK(checkAxes(description.axes, format, subject));
    LC_CHECK(checkLmbake(description.lmbake, format, subject));
    const Result<LightMapDescription> complete = withImplied(description, format, subject);
    if (!complete) return tl::make_unexpected(complete.error());
    LC_CHECK(checkDirections(file, description, format));
    Result<std::unique_ptr<BakeReader>> reader = bake->open();
    if (!reader) return tl::make_unexpected(reader.error());
    if (complete->frame == ShFrame::Tangent && !(*reader)->hasNormals()) {
        return failure(ErrorCode::WrongShape, subject, "found no channels normal.X/Y/Z, expected them because the frame is \"tangent\"");
    }
    LC_CHECK(checkSlices(description.lmbake, **reader, subject));
    // Normals of the mesh are in its axes.
    const bool takesTangents = complete->takesTangents;
    const BakeAxes normalAxes = (*reader)->hasNormals() && !takesTangents ? complete->axes : BakeAxes();
    bool hasMeshNormals = format.needsMesh() || takesTangents;
    const bool takesCoverage = complete->coverage == CoverageSource::Mesh;
    if (takesCoverage && complete->mesh.empty())
        return failure(ErrorCode::InvalidRequest, subject,
                       "found coverage \"mesh\" without a mesh, expected mesh = \"FILE\" (--mesh) with light-map UVs");
    if (takesTangents && complete->mesh.empty())
        return failure(
            ErrorCode::InvalidRequest, subject,
            "found no mesh, expected mesh = \"FILE\" (--mesh) with light-map UVs: the layout stores light relative to tangents of "
            "the surface");
    if (takesTangents && !complete->outputAxes.isIdentity())
        return failure(ErrorCode::InvalidRequest, subject.at("output_axes"),
                       "found output_axes for a layout in tangent space, expected none: its light is relative to the surface in any axes");
    if (takesTangents && complete->frame == ShFrame::Tangent)
        return failure(ErrorCode::InvalidRequest, subject,
                       "found frame \"tangent\" for a layout that takes the normals of the mesh, expected \"world\"");
    if (takesCoverage || takesTangents || (!complete->mesh.empty() && !(*reader)->hasNormals())) {
        Result<SurfaceFrames> frames =
            SurfaceFrames::load(complete->mesh, (*reader)->width(), (*reader)->height(), complete->lmbake, complete->places);
        // A mesh without light-map UVs is named where it is cooked, with what its format offers in their place.
        if (!frames && (takesCoverage || takesTangents || !complete->lmbake.empty() || !complete->places.empty()))
            return tl::make_unexpected(frames.error());
        if (takesTangents && !frames->hasTangents())
            return failure(
                ErrorCode::WrongShape, complete->mesh,
                "found no tangents, expected an attribute TANGENT, or texture coordinates TEXCOORD_0 that span an area: the layout "
                "stores light relative to them");
        hasMeshNormals |= frames.has_value() && !(*reader)->hasNormals();
        if (frames) *reader = std::make_unique<OnMesh>(std::move(*reader), std::move(*frames), takesCoverage, takesTangents);
    }
    if (complete->coverage == CoverageSource::Light) *reader = coveredByLight(std::move(*reader));
    const Result<LinearConversion> colors = linearConversion(complete->colors, bake->chromaticities);
    if (!colors) return failure(colors.error().code, subject.at(colors.error().subject), colors.error().detail);
    std::optional<StatedPrimaries> primaries;
    if (bake->chromaticities) primaries = statedPrimaries(*bake->chromaticities, *colors);
    return LightMapReader(std::unique_ptr<State>(new State{std::move(bake->recognition), std::move(*reader), colors->luminanceWeights,
                                                           colors->bt2020FromWorking, std::move(primaries), hasMeshNormals, takesTangents,
                                                           Canonicalizer(subject, *complete, *colors, normalAxes)}));
}

Result<BakeRecognition> LightMapReader::recognize(const std::filesystem::path& file, const LightMapDescription& description) {
    return openBake(file, description).map([](OpenBake bake) { return std::move(bake.recognition); });
}

Result<LightMapStrip> LightMapReader::read(int firstRow, int rowCount) const {
    assert(0 <= firstRow && 0 <= rowCount && firstRow + rowCount <= height());
    if (rowCount == 0) {
        LightMapStrip empty;
        empty.firstRow = firstRow;
        return empty;
    }
    Result<RawStrip> raw = state_->reader->read(firstRow, rowCount);
    if (!raw) return tl::make_unexpected(raw.error());
    return state_->canonical(std::move(*raw), firstRow, *state_->reader);
}

Result<std::string> LightMapReader::storedDigest(int firstRow, int rowCount) const {
    return state_->reader->storedDigest(firstRow, rowCount);
}

Subject LightMapReader::placeOf(std::size_t coefficient, int colour, int x, int y) const {
    return state_->canonical.nameOf(coefficient, colour, x, y, *state_->reader);
}

}  // namespace lightcook::formats
