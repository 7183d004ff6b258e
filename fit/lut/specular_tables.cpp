#include "fit/specular_tables.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <stdexcept>
#include <string>

namespace lightcook::fit {
namespace {

constexpr double kSmallestM = 1e-4, kLargestM = 1.0;

TableAxis makeAxis(int count, double minimum, double maximum) {
    TableAxis axis{count, minimum, maximum, 0, 0.5 / count};
    if (count == 1 || maximum == minimum) {
        axis.coordinateOffset = 0.5;  // a single value: any coordinate fetches it
        return axis;
    }
    axis.coordinateScale = (count - 1) / (count * (maximum - minimum));
    axis.coordinateOffset = 0.5 / count - minimum * axis.coordinateScale;
    return axis;
}

/// Returns the axis that covers the mapped values of [low, high].
TableAxis makeAxis(int count, const AxisMapping& mapping, double low, double high) {
    const double first = mapping.of(low), last = mapping.of(high);
    return makeAxis(count, std::min(first, last), std::max(first, last));
}

TableAxis viewAxis(const SpecularTableOptions& options) {
    return makeAxis(options.viewCount, options.view, 0, 1);
}
TableAxis roughnessAxis(const SpecularTableOptions& options) {
    return makeAxis(options.roughnessCount, options.roughness, options.minimumM, options.maximumM);
}

double mOfRow(const SpecularTableOptions& options, int roughnessIndex) {
    const double m = options.roughness.inverse(roughnessAxis(options).value(roughnessIndex));
    return std::clamp(m, options.minimumM, options.maximumM);  // rounding of the root must not leave the range
}

double cosineOfColumn(const SpecularTableOptions& options, int viewIndex) {
    return std::max(kSmallestNoV, options.view.inverse(viewAxis(options).value(viewIndex)));
}

const AxisMapping& find(const std::vector<AxisMapping>& mappings, const std::string& name) {
    for (const AxisMapping& mapping : mappings)
        if (mapping.name == name) return mapping;
    throw std::out_of_range("no axis measures " + name);
}

/// Returns the four entries of a kernel that a texel of one of the three textures holds.
using PickChannels = glm::dvec4 (*)(const lighting::AreaSpecularKernel&);
glm::dvec4 pickC(const lighting::AreaSpecularKernel& kernel) {
    return {kernel.c[0], kernel.c[2], kernel.c[3], kernel.c[6]};
}
glm::dvec4 pickD(const lighting::AreaSpecularKernel& kernel) {
    return {kernel.d[0], kernel.d[2], kernel.d[3], kernel.d[6]};
}
glm::dvec4 pickCd(const lighting::AreaSpecularKernel& kernel) {
    return {kernel.c[7], kernel.c[8], kernel.d[7], kernel.d[8]};
}

void quantize(SpecularTexture& texture) {
    glm::vec4 low = texture.values.at(0, 0), high = low;
    for (const glm::vec4& value : texture.values.texels()) {
        low = glm::min(low, value);
        high = glm::max(high, value);
    }
    texture.bias = low;
    for (int channel = 0; channel < 4; ++channel) {
        const float range = high[channel] - low[channel];
        texture.scale[channel] = range > 0 ? range : 1;
    }
    texture.stored = formats::Image<glm::u16vec4>(texture.values.width(), texture.values.height());
    for (std::size_t texel = 0; texel < texture.values.texels().size(); ++texel) {
        const glm::dvec4 stored = (glm::dvec4(texture.values.texels()[texel]) - glm::dvec4(texture.bias)) / glm::dvec4(texture.scale);
        for (int channel = 0; channel < 4; ++channel) {
            const double code = std::floor(stored[channel] * 65535 + 0.5);
            texture.stored.texels()[texel][channel] = static_cast<std::uint16_t>(std::clamp(code, 0.0, 65535.0));
        }
    }
}

/// Returns one of the three textures, quantized.
/// rows  kernels [roughness][view]
SpecularTexture makeTexture(const std::vector<std::vector<lighting::AreaSpecularKernel>>& rows, PickChannels pick) {
    const int width = static_cast<int>(rows.front().size()), height = static_cast<int>(rows.size());
    SpecularTexture texture;
    texture.values = formats::Image<glm::vec4>(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            texture.values.at(x, y) = glm::vec4(pick(rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)]));
        }
    }
    quantize(texture);
    return texture;
}

formats::Result<void> refuse(const std::string& what, const std::string& found, const std::string& expected) {
    return formats::failure(formats::ErrorCode::InvalidRequest, "specular tables, " + what, "found " + found + ", expected " + expected);
}

}  // namespace

double AxisMapping::of(double t) const {
    return std::sqrt(std::max(0.0, (factors[0] + factors[1] * t) * (factors[2] + factors[3] * t)));
}

double AxisMapping::inverse(double value) const {
    const auto& [p0, p1, q0, q1] = factors;
    const double constant = p0 * q0 - value * value, linear = p0 * q1 + p1 * q0, quadratic = p1 * q1;
    // The slope of the radicand at the solution is plus or minus this root; it has one sign over [0, 1].
    const double root = std::sqrt(std::max(0.0, linear * linear - 4 * quadratic * constant));
    const bool rises = linear + quadratic > 0;
    const double t = quadratic == 0 ? -constant / linear : ((rises ? root : -root) - linear) / (2 * quadratic);
    return std::clamp(t, 0.0, 1.0);
}

const std::vector<AxisMapping>& viewMappings() {
    static const std::vector<AxisMapping> kMappings = {{"NoV", {0, 1, 0, 1}},
                                                       {"sin(theta_v)", {1, -1, 1, 1}},
                                                       {"sqrt(1 - NoV)", {1, -1, 1, 0}},
                                                       {"sqrt(NoV)", {0, 1, 1, 0}},
                                                       {"sqrt(NoV + 0.05)", {0.05, 1, 1, 0}},
                                                       {"sqrt(NoV (NoV + 0.1))", {0, 1, 0.1, 1}},
                                                       {"sqrt((1 - NoV) (1 - 0.2 NoV))", {1, -1, 1, -0.2}},
                                                       {"sqrt((1 - NoV) (1 - 0.5 NoV))", {1, -1, 1, -0.5}},
                                                       {"sqrt((1 - NoV) (1 - 0.7 NoV))", {1, -1, 1, -0.7}},
                                                       {"sqrt((1 - NoV) (1 - 0.8 NoV))", {1, -1, 1, -0.8}},
                                                       {"sqrt((1 - NoV) (1 - 0.9 NoV))", {1, -1, 1, -0.9}},
                                                       {"sqrt((1 - NoV) (1 - 0.95 NoV))", {1, -1, 1, -0.95}}};
    return kMappings;
}

const std::vector<AxisMapping>& roughnessMappings() {
    static const std::vector<AxisMapping> kMappings = {
        {"m", {0, 1, 0, 1}}, {"sqrt(m)", {0, 1, 1, 0}}, {"sqrt(m + 0.05)", {0.05, 1, 1, 0}}, {"sqrt(m (m + 0.2))", {0, 1, 0.2, 1}}};
    return kMappings;
}

const AxisMapping& viewMapping(const std::string& name) {
    return find(viewMappings(), name);
}
const AxisMapping& roughnessMapping(const std::string& name) {
    return find(roughnessMappings(), name);
}

double TableAxis::value(int texelIndex) const {
    if (count == 1) return minimum;
    return minimum + (maximum - minimum) * texelIndex / (count - 1);
}

formats::Result<void> checkSpecularTableOptions(const SpecularTableOptions& options) {
    if (options.viewCount < 2 || options.viewCount > 1024) return refuse("view count", std::to_string(options.viewCount), "2 to 1024");
    const bool range = options.minimumM >= kSmallestM && options.minimumM <= options.maximumM && options.maximumM <= kLargestM;
    if (!range) {
        return refuse("range of m", std::to_string(options.minimumM) + " to " + std::to_string(options.maximumM),
                      "an ordered range inside 0.0001 to 1");
    }
    const int fewestRows = options.minimumM == options.maximumM ? 1 : 2;
    if (options.roughnessCount < fewestRows || options.roughnessCount > 1024)
        return refuse("roughness count", std::to_string(options.roughnessCount), std::to_string(fewestRows) + " to 1024");
    if (options.pointCount < 4 || options.pointCount > 32) return refuse("point count", std::to_string(options.pointCount), "4 to 32");
    return {};
}

std::vector<lighting::AreaSpecularKernel> integrateSpecularTableRow(const SpecularTableOptions& options, int roughnessIndex) {
    assert(checkSpecularTableOptions(options).has_value() && 0 <= roughnessIndex && roughnessIndex < options.roughnessCount);
    const double m = mOfRow(options, roughnessIndex);
    std::vector<lighting::AreaSpecularKernel> row;
    row.reserve(static_cast<std::size_t>(options.viewCount));
    for (int viewIndex = 0; viewIndex < options.viewCount; ++viewIndex)
        row.push_back(
            lighting::areaSpecular(cosineOfColumn(options, viewIndex), m, options.lobe, options.normalization, options.pointCount));
    return row;
}

SpecularTables assembleSpecularTables(const SpecularTableOptions& options,
                                      const std::vector<std::vector<lighting::AreaSpecularKernel>>& rows) {
    assert(static_cast<int>(rows.size()) == options.roughnessCount);
    SpecularTables tables;
    tables.options = options;
    tables.view = viewAxis(options);
    tables.roughness = roughnessAxis(options);
    tables.c0236 = makeTexture(rows, pickC);
    tables.d0236 = makeTexture(rows, pickD);
    tables.cd78 = makeTexture(rows, pickCd);
    return tables;
}

SpecularTables makeSpecularTables(const SpecularTableOptions& options) {
    std::vector<std::vector<lighting::AreaSpecularKernel>> rows;
    for (int roughnessIndex = 0; roughnessIndex < options.roughnessCount; ++roughnessIndex) {
        rows.push_back(integrateSpecularTableRow(options, roughnessIndex));
    }
    return assembleSpecularTables(options, rows);
}

glm::vec4 sampleSpecularTexture(const SpecularTexture& texture, double u, double v) {
    const int width = texture.stored.width(), height = texture.stored.height();
    const double x = std::clamp(u * width - 0.5, 0.0, width - 1.0), y = std::clamp(v * height - 0.5, 0.0, height - 1.0);
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, width - 1), y1 = std::min(y0 + 1, height - 1);
    const auto stored = [&](int column, int row) { return glm::dvec4(texture.stored.at(column, row)) / 65535.0; };
    const glm::dvec4 top = glm::mix(stored(x0, y0), stored(x1, y0), x - x0);
    const glm::dvec4 bottom = glm::mix(stored(x0, y1), stored(x1, y1), x - x0);
    return glm::vec4(glm::mix(top, bottom, y - y0) * glm::dvec4(texture.scale) + glm::dvec4(texture.bias));
}

}  // namespace lightcook::fit
