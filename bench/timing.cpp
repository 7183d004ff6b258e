#include "bench/timing.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "bench/cpu_time.h"
#include "pipeline/assets/textures.h"

namespace lightcook::bench {
namespace {

using formats::PixelFormat;

/// The blocks of a picture that are encoded: all, or evenly spread ones.
struct Sample {
    formats::Image<glm::vec4> texels;
    formats::Image<float> significance;
    double share = 1;
    double mpix() const { return 1e-6 * static_cast<double>(texels.texels().size()); }
};

template <class T>
formats::Image<T> copyOf(formats::ImageView<const T> view) {
    formats::Image<T> image(view.width, view.height);
    for (int y = 0; y < view.height; ++y) std::copy_n(view.row(y), view.width, image.view().row(y));
    return image;
}

/// Returns the whole picture for stride 1; else every stride-th block, packed into rows of blocks. Blocks are encoded independently, so
/// that their results are those of the whole picture.
Sample sampled(PixelFormat format, formats::ImageView<const glm::vec4> texels, formats::ImageView<const float> significance, int stride) {
    constexpr int kBlocksPerRow = 16;  // few, so that rows of blocks can be spread over threads
    const int blockWidth = formats::info(format).blockWidth, blockHeight = formats::info(format).blockHeight;
    const int across = formats::blocksAcross(format, texels.width), count = across * formats::blocksDown(format, texels.height);
    const int taken = std::max(1, (count - stride / 2 + stride - 1) / stride);
    if (stride == 1) return {copyOf(texels), copyOf(significance), 1};
    const int packedAcross = std::min(kBlocksPerRow, taken), packedDown = (taken + packedAcross - 1) / packedAcross;
    Sample sample{formats::Image<glm::vec4>(packedAcross * blockWidth, packedDown * blockHeight),
                  formats::Image<float>(packedAcross * blockWidth, packedDown * blockHeight), static_cast<double>(taken) / count};
    // Places that are left over in the last row repeat the last block with significance 0.
    for (int place = 0; place < packedAcross * packedDown; ++place) {
        const int block = std::min(stride / 2 + std::min(place, taken - 1) * stride, count - 1);
        for (int y = 0; y < blockHeight; ++y)
            for (int x = 0; x < blockWidth; ++x) {
                const int fromX = block % across * blockWidth + x, fromY = block / across * blockHeight + y;
                const int toX = place % packedAcross * blockWidth + x, toY = place / packedAcross * blockHeight + y;
                const bool counts = place < taken && fromX < texels.width && fromY < texels.height;
                const int insideX = std::min(fromX, texels.width - 1), insideY = std::min(fromY, texels.height - 1);
                sample.texels.at(toX, toY) = texels.at(insideX, insideY);
                sample.significance.at(toX, toY) = counts ? significance.at(insideX, insideY) : 0.0f;
            }
    }
    return sample;
}

double wallSeconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Encodes as the program does, with the rows of blocks spread over the threads.
std::vector<std::byte> encode(PixelFormat format, int effort, const Sample& sample, tbb::task_arena& arena) {
    compress::EncodeOptions options;
    options.effort = effort;
    compress::EncodeReport report;
    return arena.execute([&] { return pipeline::encodeImage(format, sample.texels.view(), sample.significance.view(), options, report); });
}

/// Returns the seconds of the fastest of up to three runs. A run that took longer than `enough` [s] is the last.
template <class Clock>
double fastest(PixelFormat format, int effort, const Sample& sample, tbb::task_arena& arena, double enough, const Clock& clock) {
    double best = std::numeric_limits<double>::infinity();
    for (int run = 0; run < 3; ++run) {
        const double start = clock();
        encode(format, effort, sample, arena);
        best = std::min(best, clock() - start);
        if (best > enough) break;
    }
    return std::max(best, 1e-9);
}

Figures figuresOf(PixelFormat format, int effort, const Sample& sample, tbb::task_arena& arena) {
    const std::vector<std::byte> bytes = encode(format, effort, sample, arena);
    return measure(format, sample.texels.view(), sample.significance.view(),
                   decodedByVerifier(format, bytes, sample.texels.width(), sample.texels.height()).view());
}

}  // namespace

Timing timeEncoder(PixelFormat format, int effort, const Picture& picture, double secondsEach, const std::optional<Control>& control) {
    // Kept for the life of the program, so that starting threads is not part of the time.
    static const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 2);
    static tbb::task_arena one(1), two(2);
    const formats::Image<glm::vec4> texels = texelsFor(picture, format);
    // A run on about 256 blocks estimates the time of the whole picture.
    constexpr int kEstimateBlocks = 256;
    const int blocks = formats::blocksAcross(format, texels.width()) * formats::blocksDown(format, texels.height());
    Sample sample = sampled(format, texels.view(), picture.significance.view(), std::max(2, blocks / kEstimateBlocks));
    const double whole = fastest(format, effort, sample, one, 0, processSeconds) / sample.share;
    // The stride is odd, so that the blocks are not all of the same columns.
    const int stride = std::clamp(static_cast<int>(std::ceil(whole / secondsEach)), 1, blocks) | 1;
    sample = sampled(format, texels.view(), picture.significance.view(), stride);

    Timing timing;
    timing.share = sample.share;
    timing.mpixPerCpuSecond = sample.mpix() / fastest(format, effort, sample, one, secondsEach / 3, processSeconds);
    timing.mpixPerSecond2 = sample.mpix() / fastest(format, effort, sample, two, secondsEach / 3, wallSeconds);
    // Without a control, encode the whole picture once, unless that takes far longer than the limit: later efforts use it as their control.
    constexpr double kControlLimit = 20;  // over secondsEach
    if (timing.share < 1 && !control && whole < kControlLimit * secondsEach) {
        sample = sampled(format, texels.view(), picture.significance.view(), 1);
        timing.share = 1;
    }
    timing.figures = figuresOf(format, effort, sample, one);
    timing.wholeDb = timing.figures.psnrDb;
    if (timing.share < 1 && control) timing.wholeDb += control->db - figuresOf(format, control->effort, sample, one).psnrDb;
    return timing;
}

}  // namespace lightcook::bench
