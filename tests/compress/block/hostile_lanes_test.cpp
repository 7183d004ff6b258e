// Hostile blocks through the kernels with one lane and with a whole vector: the codes are the same.
#include "tests/compress/hostile_blocks.h"
//

#include "compress/bc1/fit-inl.h"
#include "compress/bc4/fit-inl.h"
#include "compress/bc6h/fit-inl.h"
#include "compress/bc7/full/search-inl.h"
#include "tests/soak/soak.h"

// The kernels are compiled for Highway's target, so the code that inlines them must be too.
HWY_BEFORE_NAMESPACE();
namespace lightcook::compress::test {
namespace {

using formats::PixelFormat;
namespace kernel = HWY_NAMESPACE;
using OneLane = kernel::hn::CappedTag<float, 1>;
using AllLanes = kernel::hn::ScalableTag<float>;

/// Gathers the blocks of an image as encodeRows does, with weights as in a light map.
std::vector<Block> blocksOf(const HostileImage& image, PixelFormat format, Random& random) {
    std::vector<Block> blocks;
    for (int y = 0; y < image.texels.height(); y += 4)
        for (int x = 0; x < image.texels.width(); x += 4) {
            Block& block = blocks.emplace_back();
            for (std::size_t t = 0; t < kTexelCount; ++t) {
                block.significance[t] = static_cast<float>(random.below(3)) / 2;
                for (std::size_t c = 0; c < 4; ++c) {
                    const float largest = rangeOf(format).high[static_cast<int>(c)],
                                least = formats::info(format).isSigned ? -largest : 0.0f;
                    const float value = image.texels.at(x + static_cast<int>(t) % 4, y + static_cast<int>(t) / 4)[static_cast<int>(c)];
                    block.channel[c][t] = std::clamp(value, least, largest) + 0.0f;
                }
            }
            block.significance[static_cast<std::size_t>(random.below(kTexelCount))] = 1;
        }
    return blocks;
}

bool same(const Bc6hResult& a, const Bc6hResult& b) {
    return a.mode == b.mode && a.partition == b.partition && a.code == b.code && a.index == b.index;
}
bool same(const Bc7Result& a, const Bc7Result& b) {
    return a.mode == b.mode && a.code == b.code && a.index == b.index;
}
bool same(const Bc1Result& a, const Bc1Result& b) {
    return a.first == b.first && a.second == b.second && a.threeColours == b.threeColours;
}
bool same(const Bc4Result& a, const Bc4Result& b) {
    return a.low == b.low && a.high == b.high && a.sixValues == b.sixValues;
}

template <class D, class Result, class Fit, class Run>
std::vector<Result> hostileResults(const std::vector<Block>& blocks, Fit fit, Run run) {
    std::vector<const Block*> pointers;
    for (const Block& block : blocks) pointers.push_back(&block);
    std::vector<Result> found(blocks.size());
    if constexpr (std::is_same_v<Result, Bc7Result>) {
        run(fit, pointers, found.data());
    } else {
        for (std::size_t first = 0; first < blocks.size(); first += kernel::hn::Lanes(D()))
            run(fit, pointers.data() + first, found.data() + first);
    }
    return found;
}

/// Compares Fit<D> with one lane and with all lanes over hostile blocks, a multiple of every vector width at a time.
template <template <class> class Fit, class Result, class Search, class Run, class... More>
void expectAlike(PixelFormat format, int level, std::int64_t blockCount, std::uint64_t seed, const Search& search, Run run,
                 const More&... more) {
    Random random(static_cast<std::uint64_t>(level) + seed);
    for (; blockCount > 0; blockCount -= 4096) {
        HostileImage image = makeHostileImage(random, static_cast<int>(std::min<std::int64_t>(4096, blockCount + 63) / 64 * 64), level);
        const std::vector<Block> blocks = blocksOf(image, format, random);
        const auto make = [&]<class D>(D) {
            if constexpr (std::is_constructible_v<Fit<D>, const Search&, const EncodeOptions&, More...>)
                return Fit<D>(search, image.options, more...);
            else
                return Fit<D>(search);
        };
        const auto one = hostileResults<OneLane, Result>(blocks, make(OneLane()), run);
        const auto all = hostileResults<AllLanes, Result>(blocks, make(AllLanes()), run);
        for (std::size_t i = 0; i < blocks.size(); ++i)
            if (!same(one[i], all[i])) {
                const auto x = static_cast<int>(i % 64) * 4, y = static_cast<int>(i / 64) * 4;
                ADD_FAILURE() << "one lane and all of them disagree on block " << i << ": " << describeBlock(image, format, x, y);
                return;
            }
    }
}

template <class D>
using UnsignedFit = kernel::Bc6hFit<D, false>;
template <class D>
using SignedFit = kernel::Bc6hFit<D, true>;

void expectLanesAlike(int level, std::int64_t blockCount, std::uint64_t seed) {
    const auto plain = [](auto& fit, const auto& blocks, auto* found) { fit.run(blocks, found); };
    expectAlike<UnsignedFit, Bc6hResult>(PixelFormat::Bc6hUf16, level, blockCount, seed, bc6hSearchOf(level), plain);
    expectAlike<SignedFit, Bc6hResult>(PixelFormat::Bc6hSf16, level, blockCount, seed, bc6hSearchOf(level), plain);
    expectAlike<kernel::Bc7FullSearch, Bc7Result>(PixelFormat::Bc7, level, blockCount, seed, bc7SearchOf(level), plain);
    expectAlike<kernel::Bc1Fit, Bc1Result>(PixelFormat::Bc1, level, blockCount, seed, bc1SearchOf(level), plain, true);
    if (level == 9) return;  // searches every pair of ends without lanes
    expectAlike<kernel::Bc4Fit, Bc4Result>(PixelFormat::Bc4, level, blockCount, seed, bc4SearchOf(level),
                                           [](auto& fit, const Block* const* at, auto* found) { fit.run(at, 1, found); });
}

TEST(HostileLanes, OneLaneIsAsAll) {
    for (const int level : {0, 2, 5}) expectLanesAlike(level, 2048, 77);
}

TEST(HostileLanesSoak, OneLaneIsAsAllAtEveryEffort) {
    lightcook::test::repeatInSoak("blocks encoded", 4 * 8320 + 8256, [](std::uint64_t seed) {
        for (int level = 0; level < 10; ++level) expectLanesAlike(level, 4096 >> level, 10 * seed);
    });
}

}  // namespace
}  // namespace lightcook::compress::test
HWY_AFTER_NAMESPACE();
