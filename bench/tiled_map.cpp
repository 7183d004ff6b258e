#include "bench/tiled_map.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "bench/or_throw.h"
#include "compress/texel/half.h"
#include "formats/image/exr_file.h"

namespace lightcook::bench {
namespace {

/// Returns the factor on the light of a copy, from 1/2 to 2.
float factorOf(int column, int row) {
    return static_cast<float>(std::exp2(std::sin(1.7 * column + 2.9 * row)));
}

}  // namespace

void writeTiledMap(const std::filesystem::path& source, const std::filesystem::path& file, const TiledMap& map) {
    constexpr int kStripRows = 64;
    const formats::ExrReader reader = orThrow(formats::ExrReader::open(source));
    const formats::ExrInfo& info = reader.info();
    const std::size_t channelCount = info.channels.size();
    const std::size_t copyFloats = static_cast<std::size_t>(info.width) * channelCount;
    std::vector<float> texels(copyFloats * static_cast<std::size_t>(info.height));
    std::vector<formats::ExrPlane> planes;
    for (std::size_t channel = 0; channel < channelCount; ++channel)
        planes.push_back({info.channels[channel], texels.data() + channel, static_cast<std::ptrdiff_t>(channelCount),
                          static_cast<std::ptrdiff_t>(copyFloats)});
    orThrow(reader.readRows(0, info.height, planes));
    std::vector<bool> isLight;
    for (const std::string& channel : info.channels) isLight.push_back(channel.starts_with("sh"));

    formats::ExrWriter writer =
        orThrow(formats::ExrWriter::create(file, info.width * map.columns, info.height * map.rows, info.channels,
                                           map.isTiled ? formats::ExrLayout::Tiles64 : formats::ExrLayout::ScanLines));
    const std::size_t rowFloats = copyFloats * static_cast<std::size_t>(map.columns);
    std::vector<float> strip(rowFloats * kStripRows);
    const int height = info.height * map.rows;
    for (int firstRow = 0; firstRow < height; firstRow += kStripRows) {
        const int rowCount = std::min(kStripRows, height - firstRow);
        for (int y = 0; y < rowCount; ++y) {
            const int rowOfCopies = (firstRow + y) / info.height, rowOfCopy = (firstRow + y) % info.height;
            for (int column = 0; column < map.columns; ++column) {
                float* out = strip.data() + rowFloats * static_cast<std::size_t>(y) + copyFloats * static_cast<std::size_t>(column);
                const float* const in = texels.data() + copyFloats * static_cast<std::size_t>(rowOfCopy);
                if ((column + rowOfCopies) % map.period != 0) {
                    std::fill_n(out, copyFloats, 0.0f);
                    continue;
                }
                const float factor = factorOf(column, rowOfCopies);
                for (std::size_t i = 0; i < copyFloats; ++i)
                    out[i] = isLight[i % channelCount] ? compress::floatFromHalf(compress::halfFromFloat(factor * in[i])) : in[i];
            }
        }
        orThrow(writer.append(strip.data(), static_cast<std::ptrdiff_t>(rowFloats), rowCount));
    }
    orThrow(writer.commit());
}

}  // namespace lightcook::bench
