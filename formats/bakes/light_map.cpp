#include "formats/light_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "formats/image/exr_file.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace lightcook::formats {
namespace {

using lighting::ShRgb;

constexpr int kFloatsPerTexel = 3 * lighting::kShCount;
static_assert(sizeof(ShRgb) == kFloatsPerTexel * sizeof(float), "texels are 27 floats in a row for OpenEXR");
constexpr int kTileExtent = 64;
const char* const kCoverage = "coverage.Y";
const char* const kNormal[3] = {"normal.X", "normal.Y", "normal.Z"};

/// sh00.R, sh00.G, sh00.B, sh01.R .. sh08.B: the order of the floats in a ShRgb.
std::string shChannelName(int index) {
    return fmt::format("sh{:02}.{}", index / 3, "RGB"[index % 3]);
}
std::vector<std::string> shChannelNames() {
    std::vector<std::string> names;
    for (int index = 0; index < kFloatsPerTexel; ++index) names.push_back(shChannelName(index));
    return names;
}

Result<void> requireShChannels(const ExrInfo& info, const std::string& file) {
    std::vector<std::string> missing;
    for (const std::string& name : shChannelNames()) {
        if (!info.has(name)) missing.push_back(name);
    }
    if (missing.empty()) return {};
    const std::string others = missing.size() == 1 ? " is missing" : fmt::format(" and {} more are missing", missing.size() - 1);
    return failure(ErrorCode::WrongShape, file,
                   fmt::format("found {} of {} sh channels, {}{}, expected sh00.R .. sh08.B",
                               kFloatsPerTexel - static_cast<int>(missing.size()), kFloatsPerTexel, missing.front(), others));
}

/// Whether the file has normals: all three channels, or none.
Result<bool> findNormals(const ExrInfo& info, const std::string& file, ShFrame frame) {
    const auto count = std::count_if(std::begin(kNormal), std::end(kNormal), [&info](const char* name) { return info.has(name); });
    if (count != 0 && count != 3) {
        return failure(ErrorCode::WrongShape, file,
                       fmt::format("found {} of the channels normal.X, normal.Y, normal.Z, expected all or none", count));
    }
    if (count == 0 && frame == ShFrame::Tangent) {
        return failure(ErrorCode::WrongShape, file, "found no channels normal.X/Y/Z, expected them because the frame is \"tangent\"");
    }
    return count == 3;
}

bool isFinite(const ShRgb& sh) {
    bool finite = true;
    for (const glm::vec3& coefficient : sh) {
        for (int channel = 0; channel < 3; ++channel) finite &= std::isfinite(coefficient[channel]);
    }
    return finite;
}

/// From what the file stores to canonical: phase, quantity and units, frame, colour. Does nothing, bit for bit, where nothing is asked.
class Canonicalizer {
public:
    Canonicalizer() = default;
    Canonicalizer(const LightMapDescription& description, const LinearConversion& colors)
        : flipsPhase_(description.phase == ShPhase::CondonShortley),
          rotates_(description.frame == ShFrame::Tangent),
          convertsColor_(!colors.isIdentity),
          workingFromSource_(colors.workingFromSource) {
        for (std::size_t band = 0; band < bandFactors_.size(); ++band) {
            if (description.quantity == ShQuantity::Irradiance) bandFactors_[band] /= lighting::kIrradianceBands[band];
            if (description.lightUnits == LightUnits::Game) bandFactors_[band] *= std::numbers::pi;
        }
        scales_ = bandFactors_ != lighting::ShBands{1.0, 1.0, 1.0};
    }

    /// How long the stored coefficients of a band can be beside sh00, where light is nowhere negative: sqrt(2 l + 1) of radiance.
    float longest(std::size_t band) const {
        return static_cast<float>(std::sqrt(2.0 * static_cast<double>(band) + 1) * bandFactors_[0] / bandFactors_[band]);
    }
    bool isIdentity() const { return !flipsPhase_ && !scales_ && !rotates_ && !convertsColor_; }
    bool convertsColor() const { return convertsColor_; }

    ShRgb operator()(ShRgb sh, const glm::vec3& normal) const {
        if (flipsPhase_) sh = lighting::flipCondonShortley(sh);
        if (scales_) sh = lighting::convolve(sh, bandFactors_);
        if (rotates_) sh = lighting::ShRotation(lighting::worldFromTangentFrame(glm::normalize(glm::dvec3(normal)))).apply(sh);
        if (convertsColor_) {
            for (glm::vec3& coefficient : sh) coefficient = workingFromSource_ * coefficient;
        }
        return sh;
    }

private:
    bool flipsPhase_ = false, rotates_ = false, convertsColor_ = false, scales_ = false;
    lighting::ShBands bandFactors_{1.0, 1.0, 1.0};
    glm::mat3 workingFromSource_{1.0f};
};

/// The texels of a band as the file has them.
struct RawBand {
    Image<ShRgb> sh;
    Image<float> coverage;    ///< empty: the file has none
    Image<glm::vec3> normal;  ///< empty: the file has none
};

}  // namespace

struct LightMapReader::State {
    std::string file;
    ExrReader reader;
    bool repairs = false, hasCoverage = false, hasNormals = false;
    glm::vec3 luminanceWeights{0};
    Canonicalizer canonical;

    Result<RawBand> readRaw(int firstRow, int rowCount) const;
    Result<bool> isCovered(const RawBand& raw, int x, int y, LightMapStrip& band) const;
    Result<void> repairOrRefuse(ShRgb& sh, int x, int y, LightMapStrip& band) const;
    Result<void> boundBands(ShRgb& sh, int x, int y, LightMapStrip& band) const;
    Result<void> convert(ShRgb& sh, int x, int y, LightMapStrip& band) const;
    Error at(ErrorCode code, const std::string& channel, int x, int y, std::string detail) const {
        return {code, fmt::format("{}, channel {}, texel ({}, {})", file, channel, x, y), std::move(detail)};
    }
};

LightMapRepairs& LightMapRepairs::operator+=(const LightMapRepairs& other) {
    notFinite += other.notFinite;
    negativeDc += other.negativeDc;
    bandsBeyond += other.bandsBeyond;
    fireflies += other.fireflies;
    return *this;
}

LightMapReader::LightMapReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
LightMapReader::LightMapReader(LightMapReader&&) noexcept = default;
LightMapReader& LightMapReader::operator=(LightMapReader&&) noexcept = default;
LightMapReader::~LightMapReader() = default;

int LightMapReader::width() const {
    return state_->reader.info().width;
}
int LightMapReader::height() const {
    return state_->reader.info().height;
}
bool LightMapReader::hasNormals() const {
    return state_->hasNormals;
}
int LightMapReader::tileHeight() const {
    return state_->reader.info().isTiled ? state_->reader.info().tileHeight : kTileExtent;
}
glm::vec3 LightMapReader::luminanceWeights() const {
    return state_->luminanceWeights;
}

Result<LightMapReader> LightMapReader::open(const std::filesystem::path& file, const LightMapDescription& description) {
    if (description.layout != "sh9") {
        return failure(ErrorCode::InvalidRequest, fmt::format("{}, layout", file.string()),
                       fmt::format("found \"{}\", expected \"sh9\"", description.layout));
    }
    Result<ExrReader> reader = ExrReader::open(file);
    if (!reader) return tl::make_unexpected(reader.error());
    if (const auto complete = requireShChannels(reader->info(), file.string()); !complete) return tl::make_unexpected(complete.error());
    const Result<bool> hasNormals = findNormals(reader->info(), file.string(), description.frame);
    if (!hasNormals) return tl::make_unexpected(hasNormals.error());
    const Result<LinearConversion> colors = linearConversion(description.colors);
    if (!colors) {
        return failure(colors.error().code, fmt::format("{}, {}", file.string(), colors.error().subject), colors.error().detail);
    }
    const bool hasCoverage = reader->info().has(kCoverage);
    return LightMapReader(std::unique_ptr<State>(new State{file.string(), std::move(*reader), description.repair, hasCoverage, *hasNormals,
                                                           colors->luminanceWeights, Canonicalizer(description, *colors)}));
}

Result<RawBand> LightMapReader::State::readRaw(int firstRow, int rowCount) const {
    const int width = reader.info().width;
    RawBand raw;
    raw.sh = Image<ShRgb>(width, rowCount);
    std::vector<ExrPlane> planes;
    float* const firstFloat = &raw.sh.texels().data()->front().x;
    const std::vector<std::string> names = shChannelNames();
    for (std::size_t i = 0; i < names.size(); ++i) planes.push_back({names[i], firstFloat + i, kFloatsPerTexel, width * kFloatsPerTexel});
    if (hasCoverage) {
        raw.coverage = Image<float>(width, rowCount);
        planes.push_back({kCoverage, raw.coverage.texels().data(), 1, width});
    }
    if (hasNormals) {
        raw.normal = Image<glm::vec3>(width, rowCount);
        for (int axis = 0; axis < 3; ++axis) planes.push_back({kNormal[axis], &raw.normal.texels().data()->x + axis, 3, 3 * width});
    }
    if (const auto read = reader.readRows(firstRow, rowCount, planes); !read) return tl::make_unexpected(read.error());
    return raw;
}

/// Decides what lies inside a chart, and stores the normal there. (x, y) is within the band.
Result<bool> LightMapReader::State::isCovered(const RawBand& raw, int x, int y, LightMapStrip& band) const {
    if (hasCoverage && !(raw.coverage.at(x, y) > 0.5f)) return false;
    if (!hasNormals) return true;
    const glm::vec3 normal = raw.normal.at(x, y);
    for (int axis = 0; axis < 3; ++axis) {
        if (std::isfinite(normal[axis])) continue;
        if (!repairs) {
            return tl::make_unexpected(at(ErrorCode::ValueNotFinite, kNormal[axis], x, band.firstRow + y,
                                          fmt::format("found {}, expected a finite value", normal[axis])));
        }
        ++band.repairs.notFinite;
        return false;
    }
    const double length = glm::length(glm::dvec3(normal));
    if (length <= 0.5) return false;  // bakers write zero where they have no surface
    band.normal.at(x, y) = glm::vec3(glm::dvec3(normal) / length);
    return true;
}

Result<void> LightMapReader::State::repairOrRefuse(ShRgb& sh, int x, int y, LightMapStrip& band) const {
    if (!isFinite(sh)) {
        if (repairs) {
            ++band.repairs.notFinite;
            sh = ShRgb{};
            return {};
        }
        for (int i = 0; i < kFloatsPerTexel; ++i) {
            const float value = sh[static_cast<std::size_t>(i / 3)][i % 3];
            if (std::isfinite(value)) continue;
            return tl::make_unexpected(at(ErrorCode::ValueNotFinite, shChannelName(i), x, band.firstRow + y,
                                          fmt::format("found {}, expected a finite value", value)));
        }
    }
    for (int channel = 0; channel < 3; ++channel) {
        if (!(sh[0][channel] < 0)) continue;
        if (!repairs) {
            return tl::make_unexpected(at(ErrorCode::ValueOutOfRange, shChannelName(channel), x, band.firstRow + y,
                                          fmt::format("found {}, expected no negative energy in sh00", sh[0][channel])));
        }
        ++band.repairs.negativeDc;
        for (glm::vec3& coefficient : sh) coefficient[channel] = 0;
    }
    return boundBands(sh, x, y, band);
}

/// Rings of a window or of a lobe's end go a little beyond what light can be, rounding to halves too (their smallest steps are 6e-8 each);
/// four times as far is another layout, another phase or another unit.
Result<void> LightMapReader::State::boundBands(ShRgb& sh, int x, int y, LightMapStrip& band) const {
    constexpr float kAllowance = 4, kRounding = 1e-6f;
    for (int channel = 0; channel < 3; ++channel)
        for (const std::size_t degree : {1u, 2u}) {
            const std::size_t first = degree * degree, end = first + 2 * degree + 1;
            double squares = 0;
            for (std::size_t i = first; i < end; ++i) squares += static_cast<double>(sh[i][channel]) * sh[i][channel];
            const double length = std::sqrt(squares), longest = static_cast<double>(canonical.longest(degree)) * sh[0][channel];
            if (length <= kAllowance * longest + kRounding) continue;
            if (!repairs) {
                const auto name = [&](std::size_t i) { return shChannelName(static_cast<int>(3 * i) + channel); };
                return tl::make_unexpected(
                    at(ErrorCode::ValueOutOfRange, fmt::format("{} .. {}", name(first), name(end - 1)), x, band.firstRow + y,
                       fmt::format("found a length of {}, expected at most {}: {} times what light with sh00 of {} has", length,
                                   kAllowance * longest, kAllowance, sh[0][channel])));
            }
            ++band.repairs.bandsBeyond;
            for (std::size_t i = first; i < end; ++i) sh[i][channel] = static_cast<float>(sh[i][channel] * (longest / length));
        }
    return {};
}

Result<void> LightMapReader::State::convert(ShRgb& sh, int x, int y, LightMapStrip& band) const {
    const ShRgb converted = canonical(sh, band.normal.at(x, y));
    if (!isFinite(converted)) {
        return tl::make_unexpected(
            at(ErrorCode::ValueOutOfRange, "sh00.R .. sh08.B", x, band.firstRow + y,
               "found values that leave the range of float when brought to canonical units, expected less than 1e38"));
    }
    sh = converted;
    if (canonical.convertsColor()) {
        for (int channel = 0; channel < 3; ++channel) band.negativeAfterGamut += sh[0][channel] < 0 ? 1 : 0;
    }
    return {};
}

Result<LightMapStrip> LightMapReader::read(int firstRow, int rowCount) const {
    assert(0 <= firstRow && 0 <= rowCount && firstRow + rowCount <= height());
    LightMapStrip band;
    band.firstRow = firstRow;
    if (rowCount == 0) return band;
    Result<RawBand> raw = state_->readRaw(firstRow, rowCount);
    if (!raw) return tl::make_unexpected(raw.error());
    band.covered = Image<std::uint8_t>(width(), rowCount, 0);
    band.normal = Image<glm::vec3>(width(), rowCount, glm::vec3(0, 0, 1));
    for (int y = 0; y < rowCount; ++y) {
        for (int x = 0; x < width(); ++x) {
            ShRgb& sh = raw->sh.at(x, y);
            const Result<bool> covered = state_->isCovered(*raw, x, y, band);
            if (!covered) return tl::make_unexpected(covered.error());
            if (!*covered) {
                sh = ShRgb{};
                continue;
            }
            band.covered.at(x, y) = 1;
            if (const auto good = state_->repairOrRefuse(sh, x, y, band); !good) return tl::make_unexpected(good.error());
            if (state_->canonical.isIdentity()) continue;
            if (const auto good = state_->convert(sh, x, y, band); !good) return tl::make_unexpected(good.error());
        }
    }
    band.sh = std::move(raw->sh);
    return band;
}

struct LightMapWriter::State {
    ExrWriter writer;
    int width = 0, height = 0;
    Image<ShRgb> waiting;  ///< rows that do not fill a row of tiles yet
    int waitingRows = 0;
    int rowsTaken = 0;

    Result<void> flush() {
        const Result<void> written =
            writer.append(&waiting.texels().data()->front().x, std::ptrdiff_t{width} * kFloatsPerTexel, waitingRows);
        waitingRows = 0;
        return written;
    }
};

LightMapWriter::LightMapWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
LightMapWriter::LightMapWriter(LightMapWriter&&) noexcept = default;
LightMapWriter& LightMapWriter::operator=(LightMapWriter&&) noexcept = default;
LightMapWriter::~LightMapWriter() = default;

Result<LightMapWriter> LightMapWriter::create(const std::filesystem::path& file, int width, int height) {
    if (width < 1 || height < 1 || width > kLargestExtent || height > kLargestExtent) {
        return failure(ErrorCode::WrongShape, file.string(),
                       fmt::format("found {} x {} texels, expected 1 to {} a side", width, height, kLargestExtent));
    }
    Result<ExrWriter> writer = ExrWriter::create(file, width, height, shChannelNames(), ExrLayout::Tiles64);
    if (!writer) return tl::make_unexpected(writer.error());
    return LightMapWriter(
        std::unique_ptr<State>(new State{std::move(*writer), width, height, Image<ShRgb>(width, std::min(height, kTileExtent)), 0, 0}));
}

Result<void> LightMapWriter::append(ImageView<const ShRgb> rows) {
    State& state = *state_;
    assert(rows.width == state.width && state.rowsTaken + rows.height <= state.height);
    for (int y = 0; y < rows.height; ++y) {
        std::copy_n(rows.row(y), rows.width, state.waiting.view().row(state.waitingRows));
        ++state.waitingRows;
        ++state.rowsTaken;
        if (state.waitingRows < kTileExtent && state.rowsTaken < state.height) continue;
        if (const auto written = state.flush(); !written) return written;
    }
    return {};
}

Result<void> LightMapWriter::commit() {
    return state_->writer.commit();
}

}  // namespace lightcook::formats
