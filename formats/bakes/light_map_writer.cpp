#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "formats/bakes/sh9.h"
#include "formats/light_map.h"

namespace lightcook::formats {

using lighting::ShRgb;

struct LightMapWriter::State {
    ExrWriter writer;
    int width = 0, height = 0;
    Image<ShRgb> waiting;  ///< rows that do not fill a row of tiles yet
    int waitingRows = 0;
    int rowsTaken = 0;

    Result<void> flush() {
        constexpr std::ptrdiff_t kFloatsPerTexel = sizeof(ShRgb) / sizeof(float);
        const Result<void> written = writer.append(&waiting.texels().data()->front().x, kFloatsPerTexel * width, waitingRows);
        waitingRows = 0;
        return written;
    }
};

LightMapWriter::LightMapWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
LightMapWriter::LightMapWriter(LightMapWriter&&) noexcept = default;
LightMapWriter& LightMapWriter::operator=(LightMapWriter&&) noexcept = default;
LightMapWriter::~LightMapWriter() = default;

Result<LightMapWriter> LightMapWriter::create(const std::filesystem::path& file, int width, int height) {
    if (width < 1 || height < 1 || width > kLargestExtent || height > kLargestExtent) {
        return failure(ErrorCode::WrongShape, file.string(),
                       fmt::format("found {} x {} texels, expected 1 to {} a side", width, height, kLargestExtent));
    }
    Result<ExrWriter> writer = ExrWriter::create(file, width, height, sh9Channels(), ExrLayout::Tiles64);
    if (!writer) return tl::make_unexpected(writer.error());
    return LightMapWriter(
        std::unique_ptr<State>(new State{std::move(*writer), width, height, Image<ShRgb>(width, std::min(height, kTileExtent)), 0, 0}));
}

Result<void> LightMapWriter::append(ImageView<const ShRgb> rows) {
    State& state = *state_;
    assert(rows.width == state.width && state.rowsTaken + rows.height <= state.height);
    for (int y = 0; y < rows.height; ++y) {
        std::copy_n(rows.row(y), rows.width, state.waiting.view().row(state.waitingRows));
        ++state.waitingRows;
        ++state.rowsTaken;
        if (state.waitingRows < kTileExtent && state.rowsTaken < state.height) continue;
        if (const auto written = state.flush(); !written) return written;
    }
    return {};
}

Result<void> LightMapWriter::commit() {
    return state_->writer.commit();
}

}  // namespace lightcook::formats
