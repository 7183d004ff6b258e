// lightcook_encoder_bench: speed and error of the HDR block encoder at each effort, one thread, on the environments and light maps of
// ../shared/data. Counters: Mpix/s, and log2_psnr = 20 log10(1 / rms(log2(1 + x') - log2(1 + x))) over the texels that count.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <glm/vec4.hpp>
#include <memory>
#include <string>
#include <vector>

#include "compress/encode.h"
#include "compress/half.h"
#include "formats/environment.h"
#include "formats/light_map.h"

namespace bench {
namespace {

namespace fs = std::filesystem;

/// Half values: what an HDR format of half precision could hold without loss.
struct Picture {
    std::string name;
    formats::Image<glm::vec4> texels;
    formats::Image<float> significance;  ///< 1 where a texel counts
};

glm::vec4 roundedToHalf(const glm::vec4& value) {
    glm::vec4 rounded(1.0f);
    for (int channel = 0; channel < 3; ++channel) {
        rounded[channel] = compress::floatFromHalf(compress::halfFromFloat(std::max(value[channel], 0.0f)));
    }
    return rounded;
}

formats::Result<Picture> loadEnvironmentPicture(const fs::path& file) {
    formats::Result<formats::PlainImage> image = formats::readImage(file);
    if (!image) return tl::make_unexpected(image.error());
    Picture picture{file.stem(), std::move(image->texels), {}};
    for (glm::vec4& texel : picture.texels.texels()) texel = roundedToHalf(texel);
    picture.significance = formats::Image<float>(picture.texels.width(), picture.texels.height(), 1.0f);
    return picture;
}

/// Coefficient 0 of a light map; only covered texels count.
formats::Result<Picture> loadLightMapPicture(const fs::path& file) {
    formats::Result<formats::LightMapReader> reader = formats::LightMapReader::open(file, {});
    if (!reader) return tl::make_unexpected(reader.error());
    const formats::Result<formats::LightMapBand> band = reader->read(0, reader->height());
    if (!band) return tl::make_unexpected(band.error());
    Picture picture{"l0_of_" + file.stem().string(), formats::Image<glm::vec4>(reader->width(), reader->height()),
                    formats::Image<float>(reader->width(), reader->height())};
    for (int y = 0; y < reader->height(); ++y) {
        for (int x = 0; x < reader->width(); ++x) {
            picture.texels.at(x, y) = roundedToHalf(glm::vec4(band->sh.at(x, y)[0], 1.0f));
            picture.significance.at(x, y) = band->covered.at(x, y) != 0 ? 1.0f : 0.0f;
        }
    }
    return picture;
}

std::vector<std::shared_ptr<const Picture>> loadPictures() {
    std::vector<fs::path> environments, lightMaps;
    const fs::path data = LIGHTCOOK_SHARED_DATA;
    if (fs::is_directory(data)) {
        for (const auto& entry : fs::directory_iterator(data / "env")) {
            if (entry.path().extension() == ".hdr") environments.push_back(entry.path());
        }
        for (const auto& entry : fs::directory_iterator(data / "scenes")) {
            if (entry.path().filename().string().ends_with("_lightmap.exr")) lightMaps.push_back(entry.path());
        }
    } else {
        lightMaps.push_back(fs::path(LIGHTCOOK_SOURCE_DIR) / "examples/cornell/cornell_lightmap.exr");
    }
    std::sort(environments.begin(), environments.end());
    std::sort(lightMaps.begin(), lightMaps.end());
    std::vector<std::shared_ptr<const Picture>> pictures;
    const auto keep = [&pictures](formats::Result<Picture> picture) {
        if (picture) {
            pictures.push_back(std::make_shared<const Picture>(std::move(*picture)));
        } else {
            std::fprintf(stderr, "lightcook_encoder_bench: %s\n", picture.error().line().c_str());
        }
    };
    for (const fs::path& file : environments) keep(loadEnvironmentPicture(file));
    for (const fs::path& file : lightMaps) keep(loadLightMapPicture(file));
    return pictures;
}

double log2Psnr(const Picture& picture, const formats::Image<glm::vec4>& decoded) {
    double squares = 0, count = 0;
    for (std::size_t i = 0; i < decoded.texels().size(); ++i) {
        if (picture.significance.texels()[i] == 0) continue;
        for (int channel = 0; channel < 3; ++channel) {
            const double error = std::log2(1.0 + decoded.texels()[i][channel]) - std::log2(1.0 + picture.texels.texels()[i][channel]);
            squares += error * error;
            count += 1;
        }
    }
    return -10 * std::log10(squares / count);
}

void encode(benchmark::State& state, const Picture& picture, formats::PixelFormat format, int effort) {
    const int width = picture.texels.width(), height = picture.texels.height();
    std::vector<std::byte> blocks(formats::bytesPerImage(format, width, height));
    compress::EncodeOptions options;
    options.effort = effort;
    for ([[maybe_unused]] auto _ : state) {
        compress::encodeRows(format, picture.texels.view(), picture.significance.view(), options, blocks, {});
        benchmark::ClobberMemory();
    }
    formats::Image<glm::vec4> decoded(width, height);
    compress::encodeRows(format, picture.texels.view(), picture.significance.view(), options, blocks, decoded.view());
    state.counters["log2_psnr"] = log2Psnr(picture, decoded);
    state.counters["Mpix/s"] = benchmark::Counter(1e-6 * width * height, benchmark::Counter::kIsIterationInvariantRate);
}

}  // namespace
}  // namespace bench

int main(int argumentCount, char** arguments) {
    benchmark::Initialize(&argumentCount, arguments);
    if (benchmark::ReportUnrecognizedArguments(argumentCount, arguments)) return 2;
    for (const auto& picture : bench::loadPictures()) {
        for (const int effort : {0, 1, 3, 5, 7, 9}) {
            const std::string name = "bc6h-uf16/effort:" + std::to_string(effort) + "/" + picture->name;
            benchmark::RegisterBenchmark(name.c_str(), [picture, effort](benchmark::State& state) {
                bench::encode(state, *picture, formats::PixelFormat::Bc6hUf16, effort);
            })->Unit(benchmark::kMillisecond);
        }
    }
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
