#include "pipeline/report/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/assets/asset_kind.h"
#include "pipeline/graph/files.h"

namespace lightcook::pipeline {
namespace {

constexpr const char* kNotFinite = "not finite";

/// Returns the number of decimals that gives three significant digits for a value >= 0.001.
int decimalsOf(double magnitude) {
    // The limits are the values from which rounding carries into the next decade.
    if (magnitude >= 99.95) return 0;
    if (magnitude >= 9.995) return 1;
    if (magnitude >= 0.9995) return 2;
    return 3;
}

std::string threeDigits(double value) {
    return fmt::format("{:.{}f}", value, decimalsOf(std::abs(value)));
}

std::string attributeMarkup(const Attributes& attributes) {
    std::string markup;
    for (const auto& [name, value] : attributes) markup += fmt::format(" {}=\"{}\"", name, text(value).markup());
    return markup;
}

std::uint32_t bigEndian(std::string_view bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
}

bool staysInside(const std::filesystem::path& name) {
    if (name.empty() || name.is_absolute()) return false;
    for (const auto& part : name)
        if (part == "..") return false;
    return true;
}

}  // namespace

Html text(std::string_view plain) {
    std::string escaped;
    escaped.reserve(plain.size());
    for (const char c : plain) {
        const auto code = static_cast<unsigned char>(c);
        if (c == '&')
            escaped += "&amp;";
        else if (c == '<')
            escaped += "&lt;";
        else if (c == '>')
            escaped += "&gt;";
        else if (c == '"')
            escaped += "&quot;";
        else if (c == '\'')
            escaped += "&#39;";
        else if ((code < 0x20 && c != '\n' && c != '\t') || code == 0x7f)
            escaped += "\xEF\xBF\xBD";
        else
            escaped += c;
    }
    return Html(std::move(escaped));
}

Html raw(std::string_view markup) {
    return Html(std::string(markup));
}

Html element(std::string_view name, const Attributes& attributes, const Html& content) {
    return raw(fmt::format("<{}{}>{}</{}>", name, attributeMarkup(attributes), content.markup(), name));
}

Html element(std::string_view name, const Html& content) {
    return element(name, {}, content);
}

Html voidElement(std::string_view name, const Attributes& attributes) {
    return raw(fmt::format("<{}{}>", name, attributeMarkup(attributes)));
}

std::string kindColor(const std::string& kind) {
    return assetKindFromName(kind) ? "var(--kind-" + kind + ")" : "var(--kind-other)";
}

std::string base64(std::string_view bytes) {
    static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
        std::uint32_t group = 0;
        for (std::size_t i = 0; i < 3; ++i) group = group << 8 | (i < count ? static_cast<unsigned char>(bytes[at + i]) : 0u);
        for (std::size_t digit = 0; digit < 4; ++digit) out += digit <= count ? kDigits[group >> (18 - 6 * digit) & 63] : '=';
    }
    return out;
}

std::optional<Picture> loadPicture(const std::filesystem::path& folder, const std::string& name) {
    static constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
    constexpr std::size_t kHeaderBytes = 33;  // signature and the whole IHDR chunk; width at 16, height at 20
    if (!staysInside(name)) return std::nullopt;
    const auto bytes = readFile(folder / name);
    if (!bytes) return std::nullopt;
    if (bytes->size() < kHeaderBytes || std::string_view(*bytes).substr(0, kSignature.size()) != kSignature) return std::nullopt;
    return Picture{"data:image/png;base64," + base64(*bytes), bigEndian(*bytes, 16), bigEndian(*bytes, 20)};
}

std::string groupedCount(std::uint64_t count) {
    std::string digits = std::to_string(count);
    for (std::size_t at = digits.size(); at > 3;) digits.insert(at -= 3, 1, ',');
    return digits;
}

std::string humanBytes(std::uint64_t bytes) {
    static constexpr std::array kUnits = {"KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
    if (bytes < 1024) return fmt::format("{} B", bytes);
    double value = static_cast<double>(bytes) / 1024;
    std::size_t unit = 0;
    while (value >= 1023.5 && unit + 1 < kUnits.size()) {
        value /= 1024;
        ++unit;
    }
    return fmt::format("{} {}", threeDigits(value), kUnits[unit]);
}

std::string humanSeconds(double seconds) {
    if (!std::isfinite(seconds)) return kNotFinite;
    if (seconds == 0) return "0 s";
    if (seconds < 0.9995) return seconds < 1e-6 ? "< 0.001 ms" : threeDigits(1e3 * seconds) + " ms";
    if (seconds < 59.95) return threeDigits(seconds) + " s";
    if (seconds > 1e9) return fmt::format("{:.3g} s", seconds);
    const auto whole = static_cast<std::int64_t>(std::llround(seconds));
    if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
    return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string humanPercent(double ratio) {
    if (!std::isfinite(ratio)) return kNotFinite;
    const double percent = 100 * ratio;
    if (percent == 0) return "0 %";
    if (std::abs(percent) < 0.001) return percent > 0 ? "< 0.001 %" : "> -0.001 %";
    if (std::abs(percent) >= 1e6) return fmt::format("{:.3g} %", percent);
    return threeDigits(percent) + " %";
}

std::string humanNumber(double value) {
    if (!std::isfinite(value)) return kNotFinite;
    if (value == 0) return "0";
    if (std::abs(value) < 0.1 || std::abs(value) >= 1e6) return fmt::format("{:.3g}", value);
    return threeDigits(value);
}

std::string exactNumber(double value) {
    return std::isfinite(value) ? fmt::format("{}", value) : kNotFinite;
}

}  // namespace lightcook::pipeline
