#include "compress/bc6h/modes.h"

#include <cassert>
#include <string_view>
#include <vector>

namespace lightcook::compress {
namespace {

/// Fields of each mode in stored order: channel, endpoint (w x y z) and bits. "gy3:0" is stored from bit 0 up to 3, "rw10:15" from bit 15
/// down to 10.
constexpr std::array<std::string_view, 14> kFields = {
    "gy4 by4 bz4 rw9:0 gw9:0 bw9:0 rx4:0 gz4 gy3:0 gx4:0 bz0 gz3:0 bx4:0 bz1 by3:0 ry4:0 bz2 rz4:0 bz3",
    "gy5 gz4 gz5 rw6:0 bz0 bz1 by4 gw6:0 by5 bz2 gy4 bw6:0 bz3 bz5 bz4 rx5:0 gy3:0 gx5:0 gz3:0 bx5:0 by3:0 ry5:0 rz5:0",
    "rw9:0 gw9:0 bw9:0 rx4:0 rw10 gy3:0 gx3:0 gw10 bz0 gz3:0 bx3:0 bw10 bz1 by3:0 ry4:0 bz2 rz4:0 bz3",
    "rw9:0 gw9:0 bw9:0 rx3:0 rw10 gz4 gy3:0 gx4:0 gw10 gz3:0 bx3:0 bw10 bz1 by3:0 ry3:0 bz0 bz2 rz3:0 gy4 bz3",
    "rw9:0 gw9:0 bw9:0 rx3:0 rw10 by4 gy3:0 gx3:0 gw10 bz0 gz3:0 bx4:0 bw10 by3:0 ry3:0 bz1 bz2 rz3:0 bz4 bz3",
    "rw8:0 by4 gw8:0 gy4 bw8:0 bz4 rx4:0 gz4 gy3:0 gx4:0 bz0 gz3:0 bx4:0 bz1 by3:0 ry4:0 bz2 rz4:0 bz3",
    "rw7:0 gz4 by4 gw7:0 bz2 gy4 bw7:0 bz3 bz4 rx5:0 gy3:0 gx4:0 bz0 gz3:0 bx4:0 bz1 by3:0 ry5:0 rz5:0",
    "rw7:0 bz0 by4 gw7:0 gy5 gy4 bw7:0 gz5 bz4 rx4:0 gz4 gy3:0 gx5:0 gz3:0 bx4:0 bz1 by3:0 ry4:0 bz2 rz4:0 bz3",
    "rw7:0 bz1 by4 gw7:0 by5 gy4 bw7:0 bz5 bz4 rx4:0 gz4 gy3:0 gx4:0 bz0 gz3:0 bx5:0 by3:0 ry4:0 bz2 rz4:0 bz3",
    "rw5:0 gz4 bz0 bz1 by4 gw5:0 gy5 by5 bz2 gy4 bw5:0 gz5 bz3 bz5 bz4 rx5:0 gy3:0 gx5:0 gz3:0 bx5:0 by3:0 ry5:0 rz5:0",
    "rw9:0 gw9:0 bw9:0 rx9:0 gx9:0 bx9:0",
    "rw9:0 gw9:0 bw9:0 rx8:0 rw10 gx8:0 gw10 bx8:0 bw10",
    "rw9:0 gw9:0 bw9:0 rx7:0 rw10:11 gx7:0 gw10:11 bx7:0 bw10:11",
    "rw9:0 gw9:0 bw9:0 rx3:0 rw10:15 gx3:0 gw10:15 bx3:0 bw10:15",
};

int readNumber(std::string_view text, std::size_t& at) {
    int number = 0;
    while (at < text.size() && text[at] >= '0' && text[at] <= '9') number = number * 10 + (text[at++] - '0');
    return number;
}

std::vector<Bc6hBit> parse(std::string_view text) {
    std::vector<Bc6hBit> bits;
    for (std::size_t at = 0; at < text.size(); ++at) {
        const auto channel = static_cast<std::uint8_t>(std::string_view("rgb").find(text[at++]));
        const auto end = static_cast<std::uint8_t>(std::string_view("wxyz").find(text[at++]));
        const int left = readNumber(text, at);
        int right = left;
        if (at < text.size() && text[at] == ':') right = readNumber(text, ++at);
        // "3:0" names bits as a register does and is stored lowest first; "10:15" is stored highest first.
        const int step = right > left ? -1 : 1;
        for (int bit = right; bit != left + step; bit += step) bits.push_back({end, channel, static_cast<std::uint8_t>(bit)});
    }
    return bits;
}

}  // namespace

int bc6hModeOf(BitReader& bits) {
    std::uint32_t header = bits.get(2);
    if (header >= 2) header |= bits.get(3) << 2;
    for (std::size_t m = 0; m < kBc6hModes.size(); ++m)
        if (kBc6hModes[m].header == header && (header < 2) == (kBc6hModes[m].headerBits == 2)) return static_cast<int>(m);
    return -1;
}

std::span<const Bc6hBit> bc6hLayout(int modeIndex) {
    static const std::array<std::vector<Bc6hBit>, 14> layouts = [] {
        std::array<std::vector<Bc6hBit>, 14> parsed;
        for (std::size_t m = 0; m < parsed.size(); ++m) {
            parsed[m] = parse(kFields[m]);
            assert(parsed[m].size() == (kBc6hModes[m].regionCount == 2 ? 77u - kBc6hModes[m].headerBits : 60u));
        }
        return parsed;
    }();
    return layouts[static_cast<std::size_t>(modeIndex)];
}

std::span<const Bc6hRun> bc6hRuns(int modeIndex) {
    static const std::array<std::vector<Bc6hRun>, 14> runs = [] {
        std::array<std::vector<Bc6hRun>, 14> joined;
        for (std::size_t m = 0; m < joined.size(); ++m)
            for (const Bc6hBit& bit : bc6hLayout(static_cast<int>(m))) {
                if (!joined[m].empty()) {
                    Bc6hRun& last = joined[m].back();
                    if (last.end == bit.end && last.channel == bit.channel && last.firstBit + last.bitCount == bit.bit) {
                        ++last.bitCount;
                        continue;
                    }
                }
                joined[m].push_back({bit.end, bit.channel, bit.bit, 1});
            }
        return joined;
    }();
    return runs[static_cast<std::size_t>(modeIndex)];
}

}  // namespace lightcook::compress
