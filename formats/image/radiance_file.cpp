#include "formats/image/radiance_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/file/file_bytes.h"
#include "formats/image/image_claims.h"
#include "formats/memory.h"

namespace lightcook::formats {
namespace {

constexpr std::size_t kLargestHeader = 1 << 16;
/// Rows of other widths are stored flat.
constexpr int kNarrowestEncoded = 8, kWidestEncoded = 32767;

/// The bytes of a file that are not read yet. Functions return nothing if too few are left.
class Bytes {
public:
    explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
    std::optional<std::span<const std::uint8_t>> take(std::size_t count) {
        if (bytes_.size() < count) return std::nullopt;
        const auto taken = bytes_.first(count);
        bytes_ = bytes_.subspan(count);
        return taken;
    }
    /// The same without taking them.
    std::optional<std::span<const std::uint8_t>> peek(std::size_t count) const {
        return bytes_.size() < count ? std::nullopt : std::optional(bytes_.first(count));
    }
    /// Up to the next line feed, which goes too.
    std::optional<std::string_view> line() {
        const std::string_view text(reinterpret_cast<const char*>(bytes_.data()), std::min(bytes_.size(), kLargestHeader));
        const std::size_t end = text.find('\n');
        if (end == std::string_view::npos) return std::nullopt;
        bytes_ = bytes_.subspan(end + 1);
        return text.substr(0, end);
    }
    std::size_t size() const { return bytes_.size(); }

private:
    std::span<const std::uint8_t> bytes_;
};

/// Removes a positive number from the head of a text and returns it.
std::optional<int> takeNumber(std::string_view& text) {
    int number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || number < 1 || number > kLargestExtent) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return number;
}

/// Order of the texels in a file: scan lines along one axis, texels along the other.
struct Orientation {
    int lineCount = 0, lineLength = 0;
    bool linesAreRows = true, linesAreReversed = false, texelsAreReversed = false;

    int width() const { return linesAreRows ? lineLength : lineCount; }
    int height() const { return linesAreRows ? lineCount : lineLength; }
};

/// Reads "-Y height +X width" or another of the eight orientations, and nothing else. Y points up and X to the right: "-Y" begins on top.
std::optional<Orientation> orientationOf(std::string_view line) {
    Orientation orientation;
    std::array<char, 2> axes{};
    for (std::size_t i = 0; i < 2; ++i) {
        if (i == 1) {
            if (!line.starts_with(' ')) return std::nullopt;
            line.remove_prefix(1);
        }
        if (line.size() < 3 || (line[0] != '-' && line[0] != '+') || (line[1] != 'X' && line[1] != 'Y') || line[2] != ' ')
            return std::nullopt;
        axes[i] = line[1];
        (i == 0 ? orientation.linesAreReversed : orientation.texelsAreReversed) = line[0] == (line[1] == 'Y' ? '+' : '-');
        line.remove_prefix(3);
        const auto count = takeNumber(line);
        if (!count) return std::nullopt;
        (i == 0 ? orientation.lineCount : orientation.lineLength) = *count;
    }
    orientation.linesAreRows = axes[0] == 'Y';
    const bool isUsable = line.empty() && axes[0] != axes[1] && std::int64_t{orientation.lineCount} * orientation.lineLength <= kMostTexels;
    return isUsable ? std::optional(orientation) : std::nullopt;
}

/// Returns eight finite numbers. Empty if the text is anything else.
std::optional<StatedChromaticities> chromaticitiesIn(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r";
    StatedChromaticities xy{};
    for (float& number : xy) {
        text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
        text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    }
    return text.find_first_not_of(kBlanks) == std::string_view::npos ? std::optional(xy) : std::nullopt;
}

/// Returns `count` factors, 1 or 3, separated by blanks. Empty if the text is anything but positive finite numbers.
std::optional<glm::dvec3> factorsIn(std::string_view text, int count) {
    constexpr std::string_view kBlanks = " \t\r";
    glm::dvec3 factors(0);
    for (int i = 0; i < count; ++i) {
        text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), factors[i]);
        if (error != std::errc() || !(factors[i] > 0) || !std::isfinite(factors[i])) return std::nullopt;
        text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    }
    if (text.find_first_not_of(kBlanks) != std::string_view::npos) return std::nullopt;
    return count == 1 ? glm::dvec3(factors.x) : factors;
}

struct RadianceHeader {
    std::optional<Orientation> orientation;  ///< empty: not a whole header of a picture that this file reads
    glm::vec3 factors{1};                    ///< see radianceFactors()
    std::optional<StatedChromaticities> chromaticities = {};
};

/// Reads the header. Fails for factors and formats that OpenImageIO would ignore, or refuse without naming them.
Result<RadianceHeader> readHeader(Bytes& bytes, const std::filesystem::path& file) {
    constexpr std::string_view kFormat = "FORMAT=", kRgbe = "32-bit_rle_rgbe", kXyze = "32-bit_rle_xyze", kPrimaries = "PRIMARIES=";
    constexpr std::array<std::pair<std::string_view, int>, 2> kFactorLines = {{{"EXPOSURE=", 1}, {"COLORCORR=", 3}}};
    constexpr std::size_t kLongestShown = 80;
    RadianceHeader header;
    const auto magic = bytes.line();
    if (!magic || !magic->starts_with("#?")) return header;
    bool isRgbe = false;
    glm::dvec3 product(1);
    auto line = bytes.line();
    for (; line && !line->empty(); line = bytes.line()) {
        const std::string_view shown = line->substr(0, kLongestShown);
        if (line->starts_with(kFormat)) {
            if (line->substr(kFormat.size()) != kRgbe)
                return failure(ErrorCode::FormatUnsupported, file,
                               fmt::format("found {}, expected {}{}", shown, kRgbe,
                                           line->substr(kFormat.size()) == kXyze ? ". Convert it: ra_xyze -r in.hdr out.hdr" : ""));
            isRgbe = true;
        }
        if (line->starts_with(kPrimaries)) {
            header.chromaticities = chromaticitiesIn(line->substr(kPrimaries.size()));
            if (!header.chromaticities)
                return failure(ErrorCode::ValueOutOfRange, file,
                               fmt::format("found {}, expected 8 finite numbers: x and y of red, green, blue and white", shown));
        }
        for (const auto& [key, count] : kFactorLines) {
            if (!line->starts_with(key)) continue;
            const auto factors = factorsIn(line->substr(key.size()), count);
            if (!factors)
                return failure(ErrorCode::ValueOutOfRange, file,
                               fmt::format("found {}, expected {} positive finite number{}", shown, count, count == 1 ? "" : "s"));
            product *= *factors;
        }
    }
    for (int i = 0; i < 3; ++i)
        if (!(product[i] >= std::numeric_limits<float>::min() && product[i] <= std::numeric_limits<float>::max()))
            return failure(ErrorCode::ValueOutOfRange, file,
                           fmt::format("found {} as the product of EXPOSURE and COLORCORR, expected 1.2e-38 to 3.4e38", product[i]));
    header.factors = glm::vec3(product);
    if (line && isRgbe)
        if (const auto resolution = bytes.line()) header.orientation = orientationOf(*resolution);
    return header;
}

/// Reads one component of a row: a count up to 128 and as many bytes, or 128 + count and the byte that repeats.
bool readComponent(Bytes& bytes, std::span<std::uint8_t> out) {
    while (!out.empty()) {
        const auto head = bytes.take(2);  // a count is always followed by a byte
        if (!head) return false;
        const std::size_t code = (*head)[0], count = code > 128 ? code - 128 : code;
        if (count == 0 || count > out.size()) return false;
        out[0] = (*head)[1];
        if (code > 128) {
            std::fill_n(out.begin(), count, (*head)[1]);
        } else {
            const auto rest = bytes.take(count - 1);
            if (!rest) return false;
            std::copy(rest->begin(), rest->end(), out.begin() + 1);
        }
        out = out.subspan(count);
    }
    return true;
}

/// 2^(exponent - 136); nothing for exponent 0, which means black. Below 10 a float of that value is denormal.
std::array<float, 256> makeScales() {
    std::array<float, 256> scales{};
    for (int exponent = 1; exponent < 256; ++exponent) {
        const int power = exponent - 136;
        scales[static_cast<std::size_t>(exponent)] =
            std::bit_cast<float>(power >= -126 ? static_cast<std::uint32_t>(power + 127) << 23 : 1u << (power + 149));
    }
    return scales;
}

void convertRow(std::span<const std::uint8_t> rgbe, std::size_t stride, std::size_t step, std::span<glm::vec3> out) {
    static const std::array<float, 256> scales = makeScales();
    for (std::size_t x = 0; x < out.size(); ++x) {
        const std::uint8_t* const texel = rgbe.data() + x * step;
        out[x] = scales[texel[3 * stride]] * glm::vec3(texel[0], texel[stride], texel[2 * stride]);
    }
}

/// Reads a scan line that is flat, or encoded by texel: (1, 1, 1, n) repeats the texel before n times, further ones in a row n * 256, ...
bool readLineOfTexels(Bytes& bytes, std::vector<std::uint8_t>& texels, std::span<glm::vec3> out) {
    constexpr int kMostShift = 24;
    texels.clear();
    const std::size_t size = 4 * out.size();
    for (int shift = 0; texels.size() < size;) {
        const auto texel = bytes.take(4);
        if (!texel) return false;
        if ((*texel)[0] != 1 || (*texel)[1] != 1 || (*texel)[2] != 1) {
            texels.insert(texels.end(), texel->begin(), texel->end());
            shift = 0;
            continue;
        }
        const std::size_t count = std::size_t{(*texel)[3]} << shift;
        if (texels.empty() || shift > kMostShift || count > (size - texels.size()) / 4) return false;
        const std::array<std::uint8_t, 4> last = {texels[texels.size() - 4], texels[texels.size() - 3], texels[texels.size() - 2],
                                                  texels[texels.size() - 1]};
        for (std::size_t i = 0; i < count; ++i) texels.insert(texels.end(), last.begin(), last.end());
        shift += 8;
    }
    convertRow(texels, 1, 4, out);
    return true;
}

/// Reads one scan line.
bool readLine(Bytes& bytes, std::vector<std::uint8_t>& planes, std::span<glm::vec3> out) {
    const std::size_t width = out.size();
    const auto head = bytes.peek(4);
    const bool isByComponent =
        width >= kNarrowestEncoded && width <= kWidestEncoded && head && (*head)[0] == 2 && (*head)[1] == 2 && (*head)[2] < 128;
    if (!isByComponent) return readLineOfTexels(bytes, planes, out);
    if (std::size_t{(*head)[2]} * 256 + (*head)[3] != width || !bytes.take(4)) return false;
    planes.resize(4 * width);
    for (std::size_t component = 0; component < 4; ++component)
        if (!readComponent(bytes, std::span(planes).subspan(component * width, width))) return false;
    convertRow(planes, width, 1, out);
    return true;
}

/// Returns the picture whose scan lines are the rows of `lines`.
Image<glm::vec3> upright(Image<glm::vec3> lines, const Orientation& orientation) {
    if (orientation.linesAreRows && !orientation.linesAreReversed && !orientation.texelsAreReversed) return lines;
    Image<glm::vec3> picture(orientation.width(), orientation.height());
    for (int line = 0; line < orientation.lineCount; ++line)
        for (int texel = 0; texel < orientation.lineLength; ++texel) {
            const int i = orientation.linesAreReversed ? orientation.lineCount - 1 - line : line;
            const int j = orientation.texelsAreReversed ? orientation.lineLength - 1 - texel : texel;
            (orientation.linesAreRows ? picture.at(j, i) : picture.at(i, j)) = lines.at(texel, line);
        }
    return picture;
}

/// Headers are a few lines: what a file has beyond this is texels.
constexpr std::size_t kLongestHeader = std::size_t{1} << 16;

/// Returns the first bytes of a file, at most `most`; none if it cannot be read, does not begin as Radiance pictures do, or is larger than
/// the memory.
std::vector<std::uint8_t> radianceContent(const std::filesystem::path& file, std::size_t most = std::numeric_limits<std::size_t>::max()) {
    const auto opened = FileBytes::openForReading(file);
    if (!opened || opened->size() < 16) return {};
    std::array<std::byte, 2> magic{};
    if (!opened->readAt(0, magic) || magic != std::array{std::byte{'#'}, std::byte{'?'}}) return {};
    const std::size_t size = std::min<std::size_t>(opened->size(), most);
    if (!checkMemory(size, "")) return {};
    std::vector<std::uint8_t> content(size);
    if (!opened->readAt(0, std::as_writable_bytes(std::span(content)))) return {};
    return content;
}

}  // namespace

std::optional<RadiancePicture> readRadiancePicture(const std::filesystem::path& file) {
    const std::vector<std::uint8_t> content = radianceContent(file);
    Bytes bytes(content);
    const auto header = readHeader(bytes, file);
    if (!header || !header->orientation) return std::nullopt;
    const Orientation& orientation = *header->orientation;
    // Refuse a header that claims more than the file can hold. The densest are scan lines of one texel and repeats of it: (1, 1, 1, 255),
    // and 256 times as many for each repeat that follows. Of those by component, a run is two bytes for up to 127 texels.
    constexpr std::size_t kDensestLine = 8;
    if (bytes.size() <
        std::min(kDensestLine, 4 * static_cast<std::size_t>(orientation.lineLength)) * static_cast<std::size_t>(orientation.lineCount))
        return std::nullopt;
    const std::uint64_t texelCount = static_cast<std::uint64_t>(orientation.lineCount) * static_cast<std::uint64_t>(orientation.lineLength);
    if (!checkMemory(texelCount * sizeof(glm::vec3), "")) return std::nullopt;
    Image<glm::vec3> lines(orientation.lineLength, orientation.lineCount);
    std::vector<std::uint8_t> planes;
    for (int y = 0; y < orientation.lineCount; ++y)
        if (!readLine(bytes, planes, {lines.view().row(y), static_cast<std::size_t>(orientation.lineLength)})) return std::nullopt;
    for (glm::vec3& texel : lines.texels()) texel /= header->factors;
    return RadiancePicture{upright(std::move(lines), orientation), header->chromaticities};
}

Result<glm::vec3> radianceFactors(const std::filesystem::path& file) {
    const std::vector<std::uint8_t> content = radianceContent(file, kLongestHeader);
    Bytes bytes(content);
    return readHeader(bytes, file).map(&RadianceHeader::factors);
}

std::optional<StatedChromaticities> radianceChromaticities(const std::filesystem::path& file) {
    const std::vector<std::uint8_t> content = radianceContent(file, kLongestHeader);
    Bytes bytes(content);
    const auto header = readHeader(bytes, file);
    return header ? header->chromaticities : std::nullopt;
}

}  // namespace lightcook::formats
