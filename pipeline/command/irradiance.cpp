#include "pipeline/command/irradiance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "fit/environment_sh.h"
#include "fit/irradiance.h"
#include "formats/environment.h"
#include "formats/lower_extension.h"
#include "lighting/radiometry.h"
#include "pipeline/command/converter.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/words.h"
#include "verify/cubemap.h"
#include "verify/texture_unit.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Image;
using formats::Result;

/// Returns the CPU time of this process, all threads [s].
double cpuSeconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

Json rowsOf(const lighting::ShRgb& sh) {
    Json rows = Json::array();
    for (const glm::vec3& c : sh) rows.push_back({c.x, c.y, c.z});
    return rows;
}

/// Compares texels of a written file with brute force.
Result<verify::IrradianceFigures> verified(const std::filesystem::path& file, float range, double wrap,
                                           const formats::Environment& environment) {
    LC_TRY(texture, formats::TextureReader::open(file));
    std::vector<Image<glm::vec4>> faces;
    for (int face = 0; face < 6; ++face) {
        LC_TRY(image, verify::decodeImage(*texture, {0, 0, face}));
        faces.push_back(std::move(*image));
    }
    return verify::compareIrradiance(faces, range, wrap, environment);
}

/// Refuses outputs that are no KTX2 file.
Result<void> checkOutput(const std::filesystem::path& output) {
    const std::string extension = formats::lowerExtension(output);
    if (extension == ".ktx2") return {};
    if (extension == ".dds") return tl::make_unexpected(constantsAreLost(output, "a .ktx2 file"));
    return failure(ErrorCode::InvalidRequest, output,
                   fmt::format("found the extension \"{}\", expected .ktx2 for an irradiance cubemap", output.extension().string()));
}

}  // namespace

Result<Json> cookIrradiance(const IrradianceCommand& command) {
    LC_CHECK(checkOutput(command.output));
    LC_TRY(loaded, formats::loadEnvironment(command.input, {colorsOf(command.source), command.repair}));
    LC_TRY(strip, fit::irradianceCubemap(loaded->environment, {command.size, command.wrap}));
    float largest = 0;
    for (const glm::vec3& texel : strip->texels()) largest = std::max({largest, texel.x, texel.y, texel.z});
    const float range = hdrRange(largest);

    formats::TextureShape shape;
    shape.format = formats::info(command.target).hdr;
    shape.width = shape.height = command.size;
    shape.faceCount = 6;
    if (command.budgetBytes && shape.gpuBytes() > *command.budgetBytes)
        return failure(ErrorCode::OverBudget, "--budget", overBudgetWords(shape.gpuBytes(), *command.budgetBytes));
    compress::EncodeReport report;
    const auto images = encodeFaces(shape.format, strip->view(), range, command.textures.encodeOptions(), report);
    const Json constants = {{"range", range}, {"wrap", command.wrap}, {"quantity", "exit radiance of a white surface"}};
    const auto metadata = textureMetadata({{"kind", "cubemap"}, {"layout", "irradiance"}, {"role", "cubemap"}, {"constants", constants}});
    // Written to a temporary folder: a file that fails its verification does not replace an earlier output.
    LC_TRY(folder, TemporaryFolder::create());
    const std::filesystem::path file = folder->path() / "irradiance.ktx2";
    LC_CHECK(writeTexture(file, shape, command.textures, metadata, images));
    const double converted = cpuSeconds();
    LC_TRY(figures, verified(file, range, command.wrap, loaded->environment));
    if (!(figures->relRms <= command.maxError))
        return failure(
            ErrorCode::Verification, command.output,
            fmt::format("found an error of {:.4f} (rms) against brute force, expected at most {:.4g}", figures->relRms, command.maxError));
    const double verifySeconds = cpuSeconds() - converted;
    LC_CHECK(copyFile(file, command.output, OutputLink::Follow));
    std::error_code code;
    return Json{{"texels", figures->texelCount},
                {"rel_rms", figures->relRms},
                {"worst", figures->worst},
                {"bytes", shape.gpuBytes()},
                {"bytes_disk", std::filesystem::file_size(command.output, code)},
                {"range", range},
                {"repaired_texels", loaded->repairedTexels},
                {"convert_cpu_seconds", converted},
                {"verify_cpu_seconds", verifySeconds}};
}

Result<Json> cookSh(const ShCommand& command) {
    if (command.output.extension() != ".json")
        return failure(
            ErrorCode::InvalidRequest, command.output,
            fmt::format("found the extension \"{}\", expected .json for nine coefficients", command.output.extension().string()));
    // The coefficients are converted in place of the texels: colours that the working space lacks have negative ones, which are exact.
    LC_TRY(conversion, formats::linearConversion(colorsOf(command.source), formats::statedChromaticities(command.input)));
    const auto loaded = formats::loadEnvironment(command.input, {{}, command.repair});
    if (!loaded) return tl::make_unexpected(loaded.error());
    lighting::ShRgb sh = fit::projectEnvironment(loaded->environment);
    if (!conversion->isIdentity)
        for (glm::vec3& coefficient : sh) coefficient = conversion->workingFromSource * coefficient;
    if (command.normalize == "d3dx")
        for (glm::vec3& coefficient : sh) coefficient *= 16.0f / 17.0f;
    const Json document = {{"sh", rowsOf(sh)},     {"exit", rowsOf(lighting::convolve(sh, lighting::wrappedLambertBands(command.wrap)))},
                           {"wrap", command.wrap}, {"normalize", command.normalize},
                           {"phase", "none"},      {"repaired_texels", loaded->repairedTexels}};
    LC_CHECK(writeFile(command.output, document.dump(1) + "\n", OutputLink::Follow));
    return document;
}

}  // namespace lightcook::pipeline
