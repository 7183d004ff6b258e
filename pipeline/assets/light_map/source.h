// Light maps as actions read them: in bands, with the rows around a band, and without decoding the same tiles for each action again.
#pragma once

#include <algorithm>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "formats/light_map.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Rows that are read together: one row of the usual tiles, and a whole number of blocks of every format.
inline constexpr int kBandRows = 64;
/// Texels that are worked on together, at most: maps too wide for it are worked on in strips, parts of a band.
inline constexpr int kStripTexels = 1 << 18;

class LightMapSources;

/// One map, open. Safe from several threads.
class LightMapSource {
public:
    int width() const { return reader_.width(); }
    int height() const { return reader_.height(); }
    int bandCount() const { return (height() + kBandRows - 1) / kBandRows; }
    glm::vec3 luminanceWeights() const { return reader_.luminanceWeights(); }

    /// Band `index`, rows [index * kBandRows, ...).
    formats::Result<std::shared_ptr<const formats::LightMapStrip>> band(int index);
    int bandRows(int index) const { return std::min(kBandRows, height() - index * kBandRows); }

    /// Strips have 64, 32 or 16 rows, by the map's width: encoding and verifying take several times what a texel takes as it was read.
    int stripCount() const { return (height() + stripHeight() - 1) / stripHeight(); }
    int stripFirstRow(int index) const { return index * stripHeight(); }
    int stripRows(int index) const { return std::min(stripHeight(), height() - stripFirstRow(index)); }
    /// The rows of strip `index` and up to `above` and `below` more, as far as the map has them.
    formats::Result<formats::LightMapStrip> stripWithMargin(int index, int above, int below);

private:
    friend class LightMapSources;
    /// What becomes of stray samples, band by band.
    struct Fireflies {
        std::string file;
        double limit;
        bool repair;
    };
    LightMapSource(LightMapSources& owner, formats::LightMapReader reader, Fireflies fireflies)
        : owner_(owner), reader_(std::move(reader)), fireflies_(std::move(fireflies)) {}
    int stripHeight() const {
        int rows = kBandRows;
        while (rows > 16 && rows * width() > kStripTexels) rows /= 2;
        return rows;
    }
    struct Slot {
        std::mutex mutex;
        std::shared_ptr<const formats::LightMapStrip> band;
    };

    LightMapSources& owner_;
    formats::LightMapReader reader_;
    Fireflies fireflies_;
    std::mutex mutex_;
    std::map<int, std::shared_ptr<Slot>> slots_;
};

/// The maps that a cook has open: each once, however many actions read it, and the decoded bands that were used last.
class LightMapSources {
public:
    /// The map stays open as long as this does.
    formats::Result<LightMapSource*> open(const std::filesystem::path& file, const formats::LightMapDescription& description);

    /// Decoded bands that are kept, of all maps together [bytes]: a 1024 x 1024 map whole, a larger one in part.
    static constexpr std::size_t kKeptBytes = std::size_t{192} << 20;

private:
    friend class LightMapSource;
    struct Kept {
        LightMapSource* source;
        int index;
        std::size_t bytes;
    };
    /// A band was used: the least recently used ones go where it takes the total over the limit.
    void keep(LightMapSource& source, int index, std::size_t bytes);

    std::mutex mutex_;
    std::map<std::string, std::unique_ptr<LightMapSource>> sources_;
    std::list<Kept> kept_;  ///< least recently used first
    std::size_t keptBytes_ = 0;
};

/// A texel of the bake.
struct BakedTexel {
    int x = 0, y = 0;
    lighting::ShRgb sh{};
    glm::vec3 normal{0};
};
/// The covered texels of a 4 x 4 block, from (x, y) on.
formats::Result<std::vector<BakedTexel>> coveredOfBlock(LightMapSource& bake, int x, int y);

/// Input of an action whose colours are converted by a configuration of the scene's own.
inline constexpr const char* kColorConfigRole = "color_config";

/// [[light_map]]'s facts as parameters of an action.
Json toJson(const formats::LightMapDescription& description);
/// The action's input "source", read as `description` (toJson of one) says; open as long as the cook.
formats::Result<LightMapSource*> openLightMap(const ActionContext& context, const Json& description);
/// The colour spaces of some JSON; a configuration file is an input of the action, so that its content counts and the file may move.
formats::ColorSpaces colorSpacesOf(const std::string& source, const std::string& working, const Action& action);

}  // namespace lightcook::pipeline
