#include "formats/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>

#include "formats/file/one_line.h"
#include "formats/image/envmap.h"
#include "formats/image/exr_colours.h"
#include "formats/image/exr_file.h"
#include "formats/image/image_claims.h"
#include "formats/image/radiance_file.h"
#include "formats/json_structure.h"
#include "formats/plain_image.h"
#include "formats/probe_place.h"
#include "formats/read_file.h"
#include "formats/srgb_curve.h"

namespace lightcook::formats {
namespace {

constexpr int kFaceCount = 6;
constexpr float kLargestHalf = 65504;

/// An image of light as stored, and what its file states.
struct RgbImage {
    Image<glm::vec3> texels;
    std::optional<StatedChromaticities> chromaticities = {};
    std::optional<ExrEnvironment> environment = {};
};

/// Reads the colours of an OpenEXR file. Takes grey for all three.
Result<RgbImage> readExrColours(const ExrReader& reader, const std::filesystem::path& file) {
    const ExrInfo& info = reader.info();
    LC_CHECK(checkExtent(info.width, info.height, 3, 3, file));
    const Result<ExrColours> colours = exrColours(info, file);
    if (!colours) return tl::make_unexpected(colours.error());
    if (!colours->hasRgb())
        return failure(ErrorCode::WrongShape, file,
                       fmt::format("found the channel{} {}, expected R, G and B, or Y for grey", info.channels.size() == 1 ? "" : "s",
                                   oneLine(fmt::format("{}", fmt::join(info.channels, ", ")))));
    RgbImage image{Image<glm::vec3>(info.width, info.height), info.chromaticities, info.environment};
    float* const first = &image.texels.texels().data()->x;
    std::vector<ExrPlane> planes;
    for (std::size_t i = 0; i < 3; ++i)
        if (!colours->channels[i].empty()) planes.push_back({colours->channels[i], first + i, 3, 3 * info.width});
    LC_CHECK(reader.readRows(0, info.height, planes));
    if (colours->isGrey)
        for (glm::vec3& texel : image.texels.texels()) texel.y = texel.z = texel.x;
    return image;
}

/// Reads the colours of an image as stored, without its alpha and other channels. Radiance and EXR files are read here without a copy as
/// RGBA.
Result<RgbImage> readRgb(const std::filesystem::path& file) {
    if (auto picture = readRadiancePicture(file)) return RgbImage{std::move(picture->texels), picture->chromaticities};
    const Result<ExrReader> exr = ExrReader::open(file);
    LC_CHECK(checkClaims(file, exr));
    if (exr) return readExrColours(*exr, file);
    const Result<PlainImage> image = readImage(file);
    if (!image) return tl::make_unexpected(image.error());
    RgbImage colours{Image<glm::vec3>(image->texels.width(), image->texels.height()), image->chromaticities};
    std::ranges::transform(image->texels.texels(), colours.texels.texels().begin(),
                           [](const glm::vec4& texel) { return glm::vec3(texel); });
    return colours;
}

tl::unexpected<Error> badTexel(const std::filesystem::path& file, int x, int y, int channel, float value, const char* when) {
    const bool finite = std::isfinite(value);
    return failure(finite ? ErrorCode::ValueOutOfRange : ErrorCode::ValueNotFinite,
                   Subject(file).at(fmt::format("channel {}, texel ({}, {})", "RGB"[channel], x, y)),
                   fmt::format("found {}{}, expected a {} value", value, when, finite ? "non-negative" : "finite"));
}

/// The first channel that is not light: NaN, infinite or negative; 3 if all are good.
int firstBadChannel(const glm::vec3& texel) {
    for (int channel = 0; channel < 3; ++channel) {
        if (!(texel[channel] >= 0) || !std::isfinite(texel[channel])) return channel;
    }
    return 3;
}

/// Returns what infinite light is repaired to: the largest finite half, or a larger value of the file.
float largestLight(const Image<glm::vec3>& texels) {
    float largest = kLargestHalf;
    for (const glm::vec3& texel : texels.texels())
        for (int channel = 0; channel < 3; ++channel)
            if (std::isfinite(texel[channel])) largest = std::max(largest, texel[channel]);
    return largest;
}

/// Returns a texel in place of one that is no light: `largest` for +infinity, black where a channel is NaN or negative.
glm::vec3 repaired(glm::vec3 texel, float largest) {
    for (int channel = 0; channel < 3; ++channel) {
        if (!(texel[channel] >= 0)) return glm::vec3(0);
        texel[channel] = std::min(texel[channel], largest);
    }
    return texel;
}

/// Refuses or repairs values that are no light and converts the others to the working space. Returns the number of repaired texels.
Result<std::int64_t> makeCanonical(RgbImage& image, const std::filesystem::path& file, const EnvironmentOptions& options) {
    Image<glm::vec3>& texels = image.texels;
    const Result<LinearConversion> colors = linearConversion(options.colors, image.chromaticities);
    if (!colors) return failure(colors.error().code, Subject(file).at(colors.error().subject), colors.error().detail);
    // Stated primaries may hold colours that the working space lacks, which is no fault of the file.
    const bool limitsGamut = options.repair || options.colors.source == kStatedSource;
    const float largest = options.repair ? largestLight(texels) : 0.0f;
    std::int64_t repairedCount = 0;
    for (int y = 0; y < texels.height(); ++y) {
        for (int x = 0; x < texels.width(); ++x) {
            glm::vec3& texel = texels.at(x, y);
            if (const int channel = firstBadChannel(texel); channel < 3) {
                if (!options.repair) return badTexel(file, x, y, channel, texel[channel], "");
                texel = repaired(texel, largest);
                ++repairedCount;
            }
            if (colors->isIdentity) continue;
            texel = colors->workingFromSource * texel;
            if (const int channel = firstBadChannel(texel); channel < 3) {
                if (!limitsGamut) return badTexel(file, x, y, channel, texel[channel], " once in the working colour space");
                for (int c = 0; c < 3; ++c) texel[c] = std::isfinite(texel[c]) ? std::max(texel[c], 0.0f) : 0.0f;
                ++repairedCount;
            }
        }
    }
    return repairedCount;
}

/// Places of the faces +X -X +Y -Y +Z -Z in an image, in cells of the size of a face.
struct FaceLayout {
    int columns, rows;
    std::array<std::array<int, 2>, kFaceCount> cells;  ///< column and row of each face
    bool isLastTurned = false;                         ///< -Z is upside down
};
constexpr std::array<FaceLayout, 4> kFaceLayouts = {
    FaceLayout{1, 6, {{{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}}}, false},
    FaceLayout{6, 1, {{{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}}}, false},
    FaceLayout{4, 3, {{{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {3, 1}}}, false},
    FaceLayout{3, 4, {{{2, 1}, {0, 1}, {1, 0}, {1, 2}, {1, 1}, {1, 3}}}, true},
};

const FaceLayout* layoutOf(const Image<glm::vec3>& texels) {
    for (const FaceLayout& layout : kFaceLayouts) {
        if (texels.width() % layout.columns == 0 && texels.width() / layout.columns * layout.rows == texels.height()) return &layout;
    }
    return nullptr;
}

/// Cells of a cross that no face lies in become black: they are no light, whatever they hold.
void clearUnusedCells(const FaceLayout& layout, Image<glm::vec3>& texels) {
    const int size = texels.width() / layout.columns;
    for (int y = 0; y < texels.height(); ++y) {
        for (int column = 0; column < layout.columns; ++column) {
            const std::array<int, 2> cell = {column, y / size};
            if (std::find(layout.cells.begin(), layout.cells.end(), cell) == layout.cells.end())
                std::fill_n(texels.view().row(y) + column * size, size, glm::vec3(0));
        }
    }
}

/// Faces as they lie in an image, as six faces from top to bottom.
Image<glm::vec3> verticalStrip(const FaceLayout& layout, const Image<glm::vec3>& texels) {
    const int size = texels.width() / layout.columns;
    Image<glm::vec3> strip(size, kFaceCount * size);
    for (int face = 0; face < kFaceCount; ++face) {
        const auto [column, row] = layout.cells[static_cast<std::size_t>(face)];
        for (int y = 0; y < size; ++y) {
            const glm::vec3* source = texels.view().row(row * size + y) + column * size;
            if (layout.isLastTurned && face == kFaceCount - 1) {
                std::reverse_copy(source, source + size, strip.view().row(face * size + size - 1 - y));
            } else {
                std::copy_n(source, size, strip.view().row(face * size + y));
            }
        }
    }
    return strip;
}

/// Six square images of one size.
Result<LoadedEnvironment> loadFaces(const std::array<std::filesystem::path, kFaceCount>& files, const EnvironmentOptions& options) {
    LoadedEnvironment loaded;
    loaded.environment.projection = Environment::Projection::CubeStrip;
    int size = 0;
    for (std::size_t face = 0; face < files.size(); ++face) {
        Result<RgbImage> image = readRgb(files[face]);
        if (!image) return tl::make_unexpected(image.error());
        const Image<glm::vec3>& texels = image->texels;
        if (face == 0) {
            size = texels.width();
            loaded.environment.texels = Image<glm::vec3>(size, kFaceCount * size);
        }
        if (texels.width() != size || texels.height() != size) {
            return failure(
                ErrorCode::WrongShape, files[face],
                fmt::format("found {} x {} texels, expected {} x {}, as its first face has", texels.width(), texels.height(), size, size));
        }
        const Result<std::int64_t> repaired = makeCanonical(*image, files[face], options);
        if (!repaired) return tl::make_unexpected(repaired.error());
        loaded.repairedTexels += *repaired;
        std::copy(texels.texels().begin(), texels.texels().end(), loaded.environment.texels.view().row(static_cast<int>(face) * size));
    }
    return loaded;
}

}  // namespace

std::vector<std::filesystem::path> faceFiles(const std::filesystem::path& file) {
    using Names = std::array<const char*, kFaceCount>;
    const std::string stem = file.stem().string();
    for (const Names& names : {Names{"posx", "negx", "posy", "negy", "posz", "negz"}, Names{"px", "nx", "py", "ny", "pz", "nz"}}) {
        for (const std::string_view name : names) {
            if (!stem.ends_with(name)) continue;
            std::vector<std::filesystem::path> files;
            for (const char* face : names)
                files.push_back(file.parent_path() / (stem.substr(0, stem.size() - name.size()) + face + file.extension().string()));
            return files;
        }
    }
    return {};
}

Result<LoadedEnvironment> loadEnvironment(const std::filesystem::path& file, const EnvironmentOptions& options) {
    Result<RgbImage> image = readRgb(file);
    if (!image) return tl::make_unexpected(image.error());
    Image<glm::vec3>* const texels = &image->texels;
    const int width = texels->width(), height = texels->height();
    const bool isEquirectangular = width == 2 * height;
    const FaceLayout* const layout = layoutOf(*texels);
    const std::vector<std::filesystem::path> faces = width == height ? faceFiles(file) : std::vector<std::filesystem::path>();
    if (!faces.empty()) {
        std::error_code code;
        for (const std::filesystem::path& face : faces)
            if (!std::filesystem::exists(face, code))
                return failure(ErrorCode::FileUnreadable, face,
                               fmt::format("found no such file, expected it: by its name the square image {} is one of six faces",
                                           file.filename().string()));
        std::array<std::filesystem::path, kFaceCount> files;
        std::copy(faces.begin(), faces.end(), files.begin());
        return loadFaces(files, options);
    }
    if (image->environment) LC_CHECK(checkEnvironmentShape(width, height, *image->environment, file));
    if (!isEquirectangular && layout == nullptr) {
        return failure(ErrorCode::WrongShape, file,
                       fmt::format("found {} x {} texels, expected 2:1 (equirectangular), 1:6 or 6:1 (six cube faces), 4:3 or 3:4 (a "
                                   "cross of faces), or one of six square files whose names end in px nx py ny pz nz",
                                   width, height));
    }
    if (layout != nullptr) clearUnusedCells(*layout, *texels);
    // Before the faces move, so that a refusal names the texel of the file.
    const Result<std::int64_t> repaired = makeCanonical(*image, file, options);
    if (!repaired) return tl::make_unexpected(repaired.error());
    if (image->environment) *texels = fromExrEnvironment(*texels, *image->environment);
    LoadedEnvironment loaded;
    loaded.repairedTexels = *repaired;
    loaded.environment.projection = isEquirectangular ? Environment::Projection::Equirectangular : Environment::Projection::CubeStrip;
    const bool isMoved = layout != nullptr && layout->rows != kFaceCount;
    loaded.environment.texels = isMoved ? verticalStrip(*layout, *texels) : std::move(*texels);
    return loaded;
}

namespace {

/// Decodes the sRGB curve (IEC 61966-2-1), texel by texel. Leaves values that are not finite or negative to makeCanonical().
Result<void> linearize(Image<glm::vec3>& texels, const std::filesystem::path& file) {
    for (int x = 0; x < texels.width(); ++x)
        for (int channel = 0; channel < 3; ++channel) {
            float& value = texels.at(x, 0)[channel];
            if (!(value > 0) || !std::isfinite(value)) continue;
            if (value > 1)
                return failure(ErrorCode::ValueOutOfRange, Subject(file).at(fmt::format("channel {}, texel ({}, 0)", "RGB"[channel], x)),
                               fmt::format("found {}, expected 0 to 1 under the sRGB curve, or encoding = \"linear\"", value));
            value = static_cast<float>(linearFromSrgb(value));
        }
    return {};
}

}  // namespace

Result<PaintedGradient> loadPaintedGradient(const std::filesystem::path& file, const EnvironmentOptions& options,
                                            GradientEncoding encoding) {
    Result<RgbImage> image = readRgb(file);
    if (!image) return tl::make_unexpected(image.error());
    Image<glm::vec3>* const texels = &image->texels;
    if (texels->height() != 1) {
        return failure(ErrorCode::WrongShape, file,
                       fmt::format("found {} x {} texels, expected N x 1 (an environment needs an axis to be averaged around)",
                                   texels->width(), texels->height()));
    }
    if (encoding == GradientEncoding::Srgb || (encoding == GradientEncoding::Auto && isPictureFile(file)))
        LC_CHECK(linearize(*texels, file));
    const Result<std::int64_t> repaired = makeCanonical(*image, file, options);
    if (!repaired) return tl::make_unexpected(repaired.error());
    return PaintedGradient{std::move(texels->texels()), *repaired};
}

namespace {

/// Nine RGB from [[r, g, b], ...], or why not.
Result<lighting::ShRgb> shFromJson(const nlohmann::json& rows, const Subject& subject) {
    const std::string expected = "expected nine rows of three finite numbers";
    if (!rows.is_array() || rows.size() != lighting::kShCount) {
        return failure(ErrorCode::WrongShape, subject, fmt::format("found {} rows, {}", rows.is_array() ? rows.size() : 0, expected));
    }
    lighting::ShRgb sh{};
    for (std::size_t i = 0; i < sh.size(); ++i) {
        if (!rows[i].is_array() || rows[i].size() != 3)
            return failure(ErrorCode::WrongShape, subject, fmt::format("found another shape in row {}, {}", i, expected));
        for (int channel = 0; channel < 3; ++channel) {
            const nlohmann::json& value = rows[i][static_cast<std::size_t>(channel)];
            const float number = value.is_number() ? value.get<float>() : NAN;
            if (!std::isfinite(number)) {
                return failure(ErrorCode::ValueNotFinite, subject,
                               fmt::format("found {} in row {}, {}", oneLine(value.dump()), i, expected));
            }
            sh[i][channel] = number;
        }
    }
    for (int channel = 0; channel < 3; ++channel)
        if (sh[0][channel] < 0)
            return failure(ErrorCode::ValueOutOfRange, subject,
                           fmt::format("found {} in row 0, the mean of the light, expected no negative energy", sh[0][channel]));
    return sh;
}

/// Returns the entry of a list of probes whose "file" has this name. Refuses two of them that differ.
Result<nlohmann::json> probeEntry(const std::filesystem::path& json, const std::string& probeFileName) {
    constexpr int kDeepest = 16;  // a list of probes is 5 deep
    LC_TRY(text, readWholeText(json));
    if (const auto fault = faultOfStructure(*text, kDeepest))
        return failure(ErrorCode::FileUnreadable, json, fmt::format("found {}, expected a list of probes", *fault));
    const nlohmann::json document = nlohmann::json::parse(*text, nullptr, false);
    if (document.is_discarded()) return failure(ErrorCode::FileUnreadable, json, "found text that is not JSON, expected a list of probes");
    if (!document.is_object() || !document.contains("probes") || !document["probes"].is_array()) {
        return failure(ErrorCode::WrongShape, json, "found no array \"probes\", expected one with \"file\" and \"sh\" of each probe");
    }
    const nlohmann::json& probes = document["probes"];
    const nlohmann::json* entry = nullptr;
    for (const nlohmann::json& probe : probes) {
        if (!probe.is_object() || !probe.contains("file") || probe["file"] != probeFileName) continue;
        if (entry != nullptr && *entry != probe)
            return failure(ErrorCode::WrongShape, json,
                           fmt::format("found two different probes with the file \"{}\", expected one", oneLine(probeFileName)));
        entry = &probe;
    }
    if (entry == nullptr)
        return failure(ErrorCode::WrongShape, json,
                       fmt::format("found {} probes, none with the file \"{}\", expected it", probes.size(), oneLine(probeFileName)));
    return *entry;
}

}  // namespace

Result<lighting::ShRgb> loadProbeSh(const std::filesystem::path& json, const std::string& probeFileName) {
    LC_TRY(probe, probeEntry(json, probeFileName));
    return shFromJson(probe->value("sh", nlohmann::json()), Subject(json).at("sh of " + probeFileName));
}

Result<std::optional<glm::dvec3>> loadProbePosition(const std::filesystem::path& json, const std::string& probeFileName) {
    LC_TRY(probe, probeEntry(json, probeFileName));
    const auto position = probe->find("position");
    if (position == probe->end()) return std::optional<glm::dvec3>();
    const auto isFiniteNumber = [](const nlohmann::json& value) { return value.is_number() && std::isfinite(value.get<double>()); };
    if (!position->is_array() || position->size() != 3 || !std::ranges::all_of(*position, isFiniteNumber))
        return failure(ErrorCode::WrongShape, Subject(json).at("position of " + probeFileName),
                       fmt::format("found {}, expected three finite numbers", oneLine(position->dump())));
    return glm::dvec3((*position)[0].get<double>(), (*position)[1].get<double>(), (*position)[2].get<double>());
}

Result<ProbePlace> loadProbePlace(const std::filesystem::path& json, const std::string& probeFileName) {
    LC_TRY(position, loadProbePosition(json, probeFileName));
    LC_TRY(probe, probeEntry(json, probeFileName));
    ProbePlace place{*position, std::nullopt, std::nullopt};
    const auto refuse = [&](const char* key, const std::string& expected) {
        return failure(ErrorCode::WrongShape, Subject(json).at(fmt::format("{} of {}", key, probeFileName)),
                       fmt::format("found {}, expected {}", oneLine(probe->at(key).dump()), expected));
    };
    const auto isNumber = [](const nlohmann::json& value) { return value.is_number() && std::isfinite(value.get<double>()); };
    const auto isPlace = [&](const nlohmann::json& value) {
        return value.is_array() && value.size() == 3 && std::ranges::all_of(value, isNumber);
    };
    if (const auto box = probe->find("box"); box != probe->end()) {
        if (!box->is_array() || box->size() != 2 || !std::ranges::all_of(*box, isPlace))
            return refuse("box", "its lowest and its highest corner, each three finite numbers");
        place.box.emplace();
        for (std::size_t corner = 0; corner < 2; ++corner)
            for (std::size_t i = 0; i < 3; ++i) (*place.box)[corner][static_cast<glm::length_t>(i)] = (*box)[corner][i].get<double>();
    }
    if (const auto radius = probe->find("radius"); radius != probe->end()) {
        if (!isNumber(*radius)) return refuse("radius", "a positive number");
        place.radius = radius->get<double>();
    }
    if (const std::string expected = objectionToProbePlace(place); !expected.empty())
        return refuse(place.radius && !(*place.radius > 0) ? "radius" : "box", expected);
    return place;
}

std::string objectionToProbePlace(const ProbePlace& place) {
    if (place.radius && !(*place.radius > 0 && std::isfinite(*place.radius))) return "a positive radius";
    if (!place.box) return "";
    for (glm::length_t i = 0; i < 3; ++i)
        if (!((*place.box)[0][i] < (*place.box)[1][i])) return "a box [lowest corner, highest corner]";
    return "";
}

}  // namespace lightcook::formats
