#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "formats/bakes/sh9.h"
#include "formats/bakes/surface_channels.h"
#include "formats/light_map.h"

namespace lightcook::formats {

using lighting::ShRgb;

struct LightMapWriter::State {
    ExrWriter writer;
    int width = 0, height = 0;
    int floatsPerTexel = 0;
    std::vector<float> waiting;  ///< rows that do not fill a row of tiles yet
    int waitingRows = 0;
    int rowsTaken = 0;

    std::ptrdiff_t rowFloats() const { return static_cast<std::ptrdiff_t>(width) * floatsPerTexel; }
    float* nextRow() { return waiting.data() + waitingRows * rowFloats(); }
    /// Counts the row that was written to nextRow(), and writes a full row of tiles.
    Result<void> takeRow() {
        ++waitingRows;
        ++rowsTaken;
        if (waitingRows < kTileExtent && rowsTaken < height) return {};
        return writer.append(waiting.data(), rowFloats(), std::exchange(waitingRows, 0));
    }
};

namespace {

constexpr int kShFloats = sizeof(ShRgb) / sizeof(float);

/// Copies a row of coefficients to texels of `floatsPerTexel`.
void copyRow(const ShRgb* texels, int width, int floatsPerTexel, float* row) {
    for (int x = 0; x < width; ++x) std::copy_n(&texels[x].front().x, kShFloats, row + static_cast<std::ptrdiff_t>(x) * floatsPerTexel);
}

}  // namespace

LightMapWriter::LightMapWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
LightMapWriter::LightMapWriter(LightMapWriter&&) noexcept = default;
LightMapWriter& LightMapWriter::operator=(LightMapWriter&&) noexcept = default;
LightMapWriter::~LightMapWriter() = default;

Result<LightMapWriter> LightMapWriter::create(const std::filesystem::path& file, int width, int height, SurfaceOutput surface) {
    if (width < 1 || height < 1 || width > kLargestExtent || height > kLargestExtent) {
        return failure(ErrorCode::WrongShape, file,
                       fmt::format("found {} x {} texels, expected 1 to {} a side", width, height, kLargestExtent));
    }
    std::vector<std::string> channels = sh9Channels();
    if (surface != SurfaceOutput::None) {
        channels.emplace_back(kCoverageChannel);
        channels.insert(channels.end(), kNormalChannels.begin(), kNormalChannels.end());
    }
    if (surface == SurfaceOutput::CoverageNormalsAndCharts) channels.emplace_back(kChartChannel);
    const int floatsPerTexel = static_cast<int>(channels.size());
    Result<ExrWriter> writer = ExrWriter::create(file, width, height, std::move(channels), ExrLayout::Tiles64);
    if (!writer) return tl::make_unexpected(writer.error());
    std::vector<float> waiting(static_cast<std::size_t>(width) * static_cast<std::size_t>(std::min(height, kTileExtent)) *
                               static_cast<std::size_t>(floatsPerTexel));
    return LightMapWriter(std::unique_ptr<State>(new State{std::move(*writer), width, height, floatsPerTexel, std::move(waiting)}));
}

Result<void> LightMapWriter::append(ImageView<const ShRgb> rows) {
    State& state = *state_;
    assert(rows.width == state.width && state.rowsTaken + rows.height <= state.height && state.floatsPerTexel == kShFloats);
    for (int y = 0; y < rows.height; ++y) {
        copyRow(rows.row(y), rows.width, kShFloats, state.nextRow());
        LC_CHECK(state.takeRow());
    }
    return {};
}

Result<void> LightMapWriter::append(ImageView<const ShRgb> rows, const SurfaceRows& surface) {
    State& state = *state_;
    const bool hasCharts = surface.chart.width > 0;
    assert(rows.width == state.width && state.rowsTaken + rows.height <= state.height &&
           state.floatsPerTexel == kShFloats + (hasCharts ? 5 : 4));
    for (int y = 0; y < rows.height; ++y) {
        float* row = state.nextRow();
        copyRow(rows.row(y), rows.width, state.floatsPerTexel, row);
        for (int x = 0; x < rows.width; ++x) {
            const glm::vec3& n = surface.normal.at(x, y);
            float* out = row + static_cast<std::ptrdiff_t>(x) * state.floatsPerTexel + kShFloats;
            *out++ = surface.covered.at(x, y) != 0 ? 1.0f : 0.0f;
            for (int axis = 0; axis < 3; ++axis) *out++ = n[axis];
            if (!hasCharts) continue;
            const std::uint32_t chart = surface.chart.at(x, y);
            *out = chart == kNoChart ? 0.0f : static_cast<float>(chart);
        }
        LC_CHECK(state.takeRow());
    }
    return {};
}

Result<void> LightMapWriter::commit() {
    return state_->writer.commit();
}

}  // namespace lightcook::formats
