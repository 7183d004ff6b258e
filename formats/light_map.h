// SH light maps as bakers write them, brought to canonical form band by band of rows: scene-linear working colour, incident radiance, world
// frame, canonical phase, finite or refused.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <string>

#include "formats/color.h"
#include "formats/error.h"
#include "formats/image.h"
#include "formats/light_map_conventions.h"
#include "lighting/sh.h"

namespace lightcook::formats {

/// What a file holds; the keys of [[light_map]] in scene.toml.
struct LightMapDescription {
    std::string layout = "sh9";  ///< 27 channels sh00.R .. sh08.B; optional coverage.Y, normal.X/Y/Z
    ShPhase phase = ShPhase::None;
    ShFrame frame = ShFrame::World;
    ShQuantity quantity = ShQuantity::Radiance;
    LightUnits lightUnits = LightUnits::Radiometric;
    ColorSpaces colors;
    /// A covered texel that outshines each of its neighbours by more than this is no light but a stray sample; 0: all are believed.
    double fireflyLimit = 1000;
    /// What is no light is mended and counted (LightMapRepairs), instead of refused.
    bool repair = false;
};

/// From 1 on, and 0.
constexpr bool isFireflyLimit(double limit) {
    return limit == 0 || (limit >= 1 && limit <= 1e30);
}

struct LightMapRepairs {
    std::int64_t notFinite = 0;    ///< covered texels set to zero because a coefficient was NaN or infinite
    std::int64_t negativeDc = 0;   ///< channels of covered texels set to zero because sh00 was negative
    std::int64_t bandsBeyond = 0;  ///< bands of a channel scaled down to what light of its sh00 can have at most
    std::int64_t fireflies = 0;    ///< covered texels that took the mean of their neighbours

    LightMapRepairs& operator+=(const LightMapRepairs& other);
};

/// Rows [firstRow, firstRow + sh.height()) of a map, all of its width.
struct LightMapStrip {
    int firstRow = 0;
    Image<lighting::ShRgb> sh;    ///< zero where not covered
    Image<std::uint8_t> covered;  ///< 1 inside charts: coverage.Y > 0.5, and a normal where the file has normals; without coverage.Y all 1
    Image<glm::vec3> normal;      ///< unit, world; (0, 0, 1) where not covered or the file has none
    LightMapRepairs repairs;      ///< of these rows
    std::int64_t negativeAfterGamut = 0;  ///< channels of sh00 that the colour conversion made negative
};

/// Opens a map and reads bands of it, tiled or scan-line, half or float, without ever holding the whole. Outside charts anything is
/// allowed.
class LightMapReader {
public:
    static Result<LightMapReader> open(const std::filesystem::path& file, const LightMapDescription& description);
    LightMapReader(LightMapReader&&) noexcept;
    LightMapReader& operator=(LightMapReader&&) noexcept;
    ~LightMapReader();

    int width() const;
    int height() const;
    bool hasNormals() const;
    int tileHeight() const;  ///< rows that are cheap to read together; 64 for scan-line files
    glm::vec3 luminanceWeights() const;

    /// Safe to call from several threads, each with rows of its own. Fireflies are left to fireflies.h, which needs neighbours.
    Result<LightMapStrip> read(int firstRow, int rowCount) const;

private:
    struct State;
    explicit LightMapReader(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Writes the 27 channels sh00.R .. sh08.B, float, canonical phase, world frame, from bands that come in order from row 0 (tiled 64 x 64,
/// ZIP). The file appears whole at commit().
class LightMapWriter {
public:
    static Result<LightMapWriter> create(const std::filesystem::path& file, int width, int height);
    LightMapWriter(LightMapWriter&&) noexcept;
    LightMapWriter& operator=(LightMapWriter&&) noexcept;
    ~LightMapWriter();
    Result<void> append(ImageView<const lighting::ShRgb> rows);
    Result<void> commit();

private:
    struct State;
    explicit LightMapWriter(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::formats
