#include "formats/shading_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>

#include "formats/read_file.h"

namespace lightcook::formats {
namespace {

constexpr std::string_view kColumns = "x,y,kind,m,f0,dx,dy,dz,r,g,b";
constexpr std::size_t kColumnCount = 11;
constexpr double kMostLight = std::numeric_limits<float>::max();  // sums of squares stay finite in doubles
using Cells = std::array<std::string_view, kColumnCount>;

std::string_view withoutReturn(std::string_view line) {
    return line.ends_with('\r') ? line.substr(0, line.size() - 1) : line;
}

/// The number of cells that the line has; those beyond the columns are counted, not kept.
std::size_t split(std::string_view line, Cells& cells) {
    std::size_t count = 0;
    for (;;) {
        const std::size_t comma = line.find(',');
        if (count < cells.size()) cells[count] = line.substr(0, comma);
        ++count;
        if (comma == std::string_view::npos) return count;
        line.remove_prefix(comma + 1);
    }
}

template <class T>
bool parse(std::string_view text, T& number) {
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    return code == std::errc() && end == text.data() + text.size();
}

class Reader {
public:
    Reader(const std::filesystem::path& file, int width, int height) : file_(file), width_(width), height_(height) {}

    Result<ShadingValue> read(std::string_view line, int number) const {
        ShadingValue value;
        value.line = number;
        Cells cells;
        if (const std::size_t count = split(line, cells); count != kColumnCount)
            return refuse(number, ErrorCode::WrongShape, fmt::format("{} columns", count), fmt::format("{}: {}", kColumnCount, kColumns));
        if (!parse(cells[0], value.x) || !parse(cells[1], value.y) || value.x < 0 || value.y < 0 || value.x >= width_ || value.y >= height_)
            return refuse(number, ErrorCode::WrongShape, fmt::format("texel ({}, {})", cells[0], cells[1]),
                          fmt::format("one of the light map's {} x {}", width_, height_));
        if (cells[2] != "lambert" && cells[2] != "spec")
            return refuse(number, ErrorCode::FormatUnsupported, fmt::format("kind '{}'", cells[2]), "lambert or spec");
        value.kind = cells[2] == "spec" ? ShadingValue::Kind::Specular : ShadingValue::Kind::Lambert;
        std::array<double, 8> numbers;
        for (std::size_t i = 0; i < numbers.size(); ++i)
            if (!parse(cells[i + 3], numbers[i]) || !std::isfinite(numbers[i]))
                return refuse(number, ErrorCode::ValueNotFinite, fmt::format("'{}'", cells[i + 3]), "a finite number");
        value.m = numbers[0];
        value.f0 = numbers[1];
        value.direction = {numbers[2], numbers[3], numbers[4]};
        value.value = {numbers[5], numbers[6], numbers[7]};
        return checked(value);
    }

private:
    Result<ShadingValue> checked(ShadingValue value) const {
        const auto outOfRange = [&](const std::string& found, const std::string& expected) {
            return refuse(value.line, ErrorCode::ValueOutOfRange, found, expected);
        };
        if (value.kind == ShadingValue::Kind::Specular && !(value.m > 0 && value.m <= 1))
            return outOfRange(fmt::format("m {}", value.m), "more than 0 and at most 1");
        if (value.kind == ShadingValue::Kind::Specular && !(value.f0 >= 0 && value.f0 <= 1))
            return outOfRange(fmt::format("f0 {}", value.f0), "0 to 1");
        if (value.value.x < 0 || value.value.y < 0 || value.value.z < 0)
            return outOfRange(fmt::format("light of ({}, {}, {})", value.value.x, value.value.y, value.value.z), "none below 0");
        if (std::max({value.value.x, value.value.y, value.value.z}) > kMostLight)
            return outOfRange(fmt::format("light of ({}, {}, {})", value.value.x, value.value.y, value.value.z),
                              fmt::format("at most {:g}, as in a bake of floats", kMostLight));
        const double length = glm::length(value.direction);
        if (!(length > 1e-6 && length < 1e6)) return outOfRange(fmt::format("a direction of length {}", length), "a unit vector");
        value.direction /= length;
        return value;
    }
    tl::unexpected<Error> refuse(int line, ErrorCode code, const std::string& found, const std::string& expected) const {
        return failure(code, Subject(file_).at(fmt::format("line {}", line)), fmt::format("found {}, expected {}", found, expected));
    }

    const std::filesystem::path& file_;
    int width_, height_;
};

}  // namespace

Result<std::vector<ShadingValue>> readShadingValues(const std::filesystem::path& file, int width, int height) {
    LC_TRY(text, readWholeText(file));
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // spreadsheets write one
    std::istringstream in(text->starts_with(kByteOrderMark) ? text->substr(kByteOrderMark.size()) : *text);
    std::string line;
    if (!std::getline(in, line) || withoutReturn(line) != kColumns)
        return failure(ErrorCode::FileUnreadable, Subject(file).at("line 1"),
                       fmt::format("found '{}', expected the columns {}", withoutReturn(line).substr(0, 80), kColumns));
    const Reader reader(file, width, height);
    std::vector<ShadingValue> values;
    for (int number = 2; std::getline(in, line); ++number) {
        if (withoutReturn(line).empty()) continue;
        LC_TRY(value, reader.read(withoutReturn(line), number));
        values.push_back(*value);
    }
    if (values.empty()) return failure(ErrorCode::WrongShape, file, "found no values, expected one a line");
    return values;
}

}  // namespace lightcook::formats
