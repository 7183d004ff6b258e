#include "bench/quality_table.h"

#include <fmt/format.h>

#include <charconv>
#include <fstream>

#include "compress/encode.h"

namespace lightcook::bench {
namespace {

constexpr std::string_view kHeader = "format,effort,picture,psnr_db,log_rmse,rel_rmse,p99_relative,max_relative";

std::vector<std::string_view> split(std::string_view line) {
    std::vector<std::string_view> fields;
    while (true) {
        const std::size_t comma = line.find(',');
        fields.push_back(line.substr(0, comma));
        if (comma == std::string_view::npos) return fields;
        line.remove_prefix(comma + 1);
    }
}

template <class Number>
bool parse(std::string_view text, Number& number) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size();
}

bool parseRow(std::string_view line, QualityRow& row) {
    const std::vector<std::string_view> fields = split(line);
    if (fields.size() != 8) return false;
    row.format = fields[0];
    row.picture = fields[2];
    Figures& f = row.figures;
    return parse(fields[1], row.effort) && parse(fields[3], f.psnrDb) && parse(fields[4], f.logRmse) && parse(fields[5], f.relRmse) &&
           parse(fields[6], f.p99Relative) && parse(fields[7], f.maxRelative);
}

}  // namespace

std::vector<formats::PixelFormat> tableFormats() {
    std::vector<formats::PixelFormat> found;
    for (const formats::PixelFormatInfo& format : formats::allPixelFormats())
        if (format.blockWidth > 1) found.push_back(format.format);
    return found;
}

Figures encodeAndMeasure(formats::PixelFormat format, int effort, const Picture& picture) {
    const formats::Image<glm::vec4> texels = texelsFor(picture, format);
    const int width = texels.width(), height = texels.height();
    std::vector<std::byte> bytes(formats::bytesPerImage(format, width, height));
    compress::EncodeOptions options;
    options.effort = effort;
    compress::encodeRows(format, texels.view(), picture.significance.view(), options, bytes, {});
    return measure(format, texels.view(), picture.significance.view(), decodedByVerifier(format, bytes, width, height).view());
}

std::vector<QualityRow> qualityRows(formats::PixelFormat format, int effort, const std::vector<Picture>& pictures) {
    std::vector<QualityRow> rows;
    for (const Picture& picture : pictures)
        if (suits(picture, format))
            rows.push_back({std::string(formats::info(format).name), picture.name, effort, encodeAndMeasure(format, effort, picture)});
    return rows;
}

double meanDb(const std::vector<QualityRow>& rows) {
    double sum = 0;
    for (const QualityRow& row : rows) sum += row.figures.psnrDb;
    return rows.empty() ? 0 : sum / static_cast<double>(rows.size());
}

std::string csvOf(const std::vector<QualityRow>& rows) {
    std::string text = fmt::format("{}\n", kHeader);
    for (const QualityRow& row : rows) {
        const Figures& f = row.figures;
        text += fmt::format("{},{},{},{:.4f},{:.6g},{:.6g},{:.6g},{:.6g}\n", row.format, row.effort, row.picture, f.psnrDb, f.logRmse,
                            f.relRmse, f.p99Relative, f.maxRelative);
    }
    return text;
}

formats::Result<std::vector<QualityRow>> readQualityTable(const std::filesystem::path& file) {
    std::ifstream stream(file);
    if (!stream) return formats::failure(formats::ErrorCode::FileUnreadable, file, "found no file, expected the quality table");
    std::vector<QualityRow> rows;
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) {
        QualityRow row;
        if (number == 1 ? line == kHeader : parseRow(line, row)) {
            if (number > 1) rows.push_back(std::move(row));
            continue;
        }
        return formats::failure(formats::ErrorCode::FormatUnsupported, fmt::format("{}:{}", file.string(), number),
                                fmt::format("found '{}', expected {}", line, number == 1 ? kHeader : "eight fields as in the first line"));
    }
    return rows;
}

}  // namespace lightcook::bench
