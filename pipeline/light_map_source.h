// Light maps as actions read them: in bands, with the rows around a band, and without decoding the same tiles for each action again.
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "formats/light_map.h"
#include "pipeline/action.h"

namespace pipeline {

/// Rows that are read and worked on together: one row of the usual tiles, and a whole number of blocks of every format.
inline constexpr int kBandRows = 64;

/// One map, open. Decoded bands are kept while they fit the limit that all open maps of a cook share. Safe from several threads.
class LightMapSource {
public:
    static formats::Result<std::shared_ptr<LightMapSource>> open(const std::filesystem::path& file,
                                                                 const formats::LightMapDescription& description);

    int width() const { return reader_.width(); }
    int height() const { return reader_.height(); }
    int bandCount() const { return (height() + kBandRows - 1) / kBandRows; }
    glm::vec3 luminanceWeights() const { return reader_.luminanceWeights(); }

    /// Band `index`, rows [index * kBandRows, ...).
    formats::Result<std::shared_ptr<const formats::LightMapBand>> band(int index);
    /// The rows of band `index` and up to `above` and `below` more, as far as the map has them.
    formats::Result<formats::LightMapBand> bandWithMargin(int index, int above, int below);
    int bandRows(int index) const { return std::min(kBandRows, height() - index * kBandRows); }

private:
    explicit LightMapSource(formats::LightMapReader reader) : reader_(std::move(reader)) {}
    struct Slot {
        std::mutex mutex;
        std::shared_ptr<const formats::LightMapBand> band;
    };
    void keep(int index);

    formats::LightMapReader reader_;
    std::mutex mutex_;  ///< of what follows
    std::map<int, std::shared_ptr<Slot>> slots_;
    std::list<int> leastRecentlyUsed_;
};

/// [[light_map]]'s facts as parameters of an action, and back.
Json toJson(const formats::LightMapDescription& description);
formats::Result<formats::LightMapDescription> lightMapDescriptionFromJson(const Json& json, const std::string& subject);

}  // namespace pipeline
