// Light maps as actions read them: in strips, with the rows around a strip, and without decoding the same tiles for each action again.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "formats/light_map.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/assets/light_map/bake_reading.h"
#include "pipeline/document/enum_names.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Rows of a chunk, which is read and kept as a whole: one row of the usual tiles, and a whole number of blocks of every format.
inline constexpr int kChunkRows = 64;
/// Strips of a bake, and decoded parts of a cooked map, begin at multiples of this many rows: they hold whole blocks of every format.
inline constexpr int kRowAlignment = 16;
/// Largest number of texels of a strip, which is the work of one task: the strips of a wide map are parts of a chunk.
inline constexpr int kStripTexels = 1 << 18;

/// Role of the light map among the files of an action; further files of the bake have "source-NAME".
inline const std::string kSourceRole = "source";
inline const std::string kFramesRole = "frames";  ///< the mesh that a bake reads: of one in tangent space, or of coverage from the mesh
inline const std::string kLmbakeRole = "lmbake";  ///< where Godot says that the nodes of the mesh lie

class LightMapSources;
class PartCache;
struct MapSurvey;
struct MipSurvey;

/// Side of the block that stands for a map of constant light [texels].
inline constexpr int kConstantSide = 4;

/// An open light map. Its functions may be called from several threads. A map of constant light (LightMapDescription::constantOf) has
/// kConstantSide rows and columns, all covered, with the normal of the first covered texel. A mip level is a light map of its own, averaged
/// from the chunks of level 0 (formats::MipReduction), which are read again for each level.
class LightMapSource {
public:
    int width() const { return constant_ ? kConstantSide : reader_->width() >> level_; }
    int height() const { return constant_ ? kConstantSide : reader_->height() >> level_; }
    int chunkCount() const { return (height() + kChunkRows - 1) / kChunkRows; }
    glm::vec3 luminanceWeights() const { return reader_->luminanceWeights(); }
    const glm::dmat3& bt2020FromWorking() const { return reader_->bt2020FromWorking(); }
    const std::optional<formats::StatedPrimaries>& primaries() const { return reader_->primaries(); }
    bool hasNormals() const { return reader_->hasNormals(); }
    bool hasMeshNormals() const { return reader_->hasMeshNormals(); }
    bool hasTangents() const { return reader_->hasTangents(); }
    bool hasCoverage() const { return reader_->hasCoverage(); }
    /// Returns how the file was recognised.
    BakeReading reading() const { return readingOf(*reader_); }
    /// Covered texels of the file that a map of constant light stands for. Empty for other maps.
    std::optional<std::int64_t> constantTexels() const { return constantTexels_; }

    /// Returns the rows [index * kChunkRows, ...), decoded once however many actions ask.
    formats::Result<std::shared_ptr<const formats::LightMapStrip>> chunk(int index);
    int chunkRows(int index) const { return std::min(kChunkRows, height() - index * kChunkRows); }

    /// Returns the places of the nodes of its mesh; empty: it lies on all nodes, or the lmbake says where.
    const std::vector<formats::NodePlace>& places() const { return description_.places; }

    /// Strips have 64, 32 or kRowAlignment rows, by the map's width: encoding and verifying take several times the memory of the rows
    /// themselves.
    int stripCount() const { return (height() + stripHeight() - 1) / stripHeight(); }
    int stripFirstRow(int index) const { return index * stripHeight(); }
    int stripRows(int index) const { return std::min(stripHeight(), height() - stripFirstRow(index)); }
    /// Returns rows [firstRow, firstRow + rowCount), all of which the map has.
    formats::Result<formats::LightMapStrip> rows(int firstRow, int rowCount);
    /// Returns the rows of a strip and up to `above` and `below` more, as far as the map has them.
    formats::Result<formats::LightMapStrip> stripWithMargin(int index, int above, int below);

    /// Return digests of all that stripWithMargin() and chunk() return: rows of equal digests are equal. Rows that a cook has had before
    /// are not decoded for them: the cache has their digests under that of what the files store of a chunk.
    formats::Result<std::string> digestOfStrip(int index, int above, int below, const PartCache& parts);
    formats::Result<std::string> digestOfChunk(int index, const PartCache& parts);

    /// Returns the figures of the whole map (survey.h), found once however many actions ask.
    /// hasSharedExit  true if a layout needs it (compress::needsSharedExit)
    formats::Result<std::shared_ptr<const MapSurvey>> survey(const ActionContext& context, bool hasSharedExit = false);
    /// Returns the mip levels that the map may have (mips.h), found once however many actions ask.
    formats::Result<const MipSurvey*> mipSurvey(const ActionContext& context);
    /// Returns a mip level, 1 or more, of a map whose mipSurvey() has it. It stays open as long as this object.
    LightMapSource& mip(int level);

private:
    friend class LightMapSources;
    /// Digests of a chunk.
    struct ChunkDigests {
        std::vector<std::string> rows;
        std::string rest;  ///< of what a strip holds beside its rows

        template <class Archive, class Self>
        static void members(Archive& archive, Self& self) {
            archive(self.rows, self.rest);
        }
    };
    LightMapSource(LightMapSources& owner, std::shared_ptr<const formats::LightMapReader> reader, formats::LightMapDescription description)
        : owner_(owner), reader_(std::move(reader)), description_(std::move(description)) {}
    LightMapSource(LightMapSource& base, int level)
        : owner_(base.owner_), reader_(base.reader_), description_(base.description_), base_(&base), level_(level) {}
    int stripHeight() const {
        int rows = kChunkRows;
        while (rows > kRowAlignment && rows * width() > kStripTexels) rows /= 2;
        return rows;
    }
    /// Reads the whole file, and refuses one of another size or with two kinds of light.
    formats::Result<void> makeConstant(const glm::ivec2& size, const std::filesystem::path& file);

    /// Reads rows of the file and checks them for fireflies.
    formats::Result<formats::LightMapStrip> readChunk(int index) const;
    /// Returns the rows [first, end) of a strip and of a margin, as far as the map has them.
    std::pair<int, int> rowsOfStrip(int index, int above, int below) const;
    formats::Result<std::shared_ptr<const ChunkDigests>> digestsOf(int index, const PartCache& parts);
    /// Returns a digest of what the files store of a chunk, and of all that decides what it means; empty: nobody knows.
    formats::Result<std::string> storedDigest(int index);
    /// Averages rows of a mip level.
    formats::Result<formats::LightMapStrip> reduceChunk(int index) const;

    struct Slot {
        std::mutex mutex;
        std::shared_ptr<const formats::LightMapStrip> chunk;
    };

    LightMapSources& owner_;
    std::shared_ptr<const formats::LightMapReader> reader_;
    formats::LightMapDescription description_;
    LightMapSource* base_ = nullptr;  ///< of a mip level: level 0
    int level_ = 0;
    std::mutex surveyMutex_;
    std::shared_ptr<const MapSurvey> survey_;
    std::shared_ptr<const MipSurvey> mipSurvey_;
    std::map<int, std::unique_ptr<LightMapSource>> mips_;  ///< [level]
    std::shared_ptr<const formats::LightMapStrip> constant_;
    std::optional<std::int64_t> constantTexels_;
    std::mutex mutex_;
    std::map<int, std::shared_ptr<Slot>> slots_;
    std::mutex digestMutex_;
    std::map<int, std::shared_ptr<const ChunkDigests>> digests_;
    std::optional<std::string> conventions_;  ///< digest of the description and of its mesh, lmbake and colours
};

/// The light maps that a cook has open, each once for all its actions, with the chunks that were used last.
class LightMapSources {
public:
    /// Opens a map, or returns it if it is open. It stays open as long as this object lives.
    formats::Result<LightMapSource*> open(const std::filesystem::path& file, const formats::LightMapDescription& description);

    /// Decoded chunks that are kept, of all maps together [bytes]: all of a 2048 x 2048 map, part of a larger one. At least two, since
    /// strips at the border of two chunks read rows of both.
    static constexpr std::size_t kKeptBytes = std::size_t{512} << 20, kLeastKept = 2;

private:
    friend class LightMapSource;
    struct Kept {
        LightMapSource* source;
        int index;
        std::size_t bytes;
    };
    /// Notes that a chunk was used, and drops the least recently used ones beyond the limit.
    void keep(LightMapSource& source, int index, std::size_t bytes);

    std::mutex mutex_;
    std::map<std::string, std::unique_ptr<LightMapSource>> sources_;
    std::list<Kept> kept_;  ///< least recently used first
    std::size_t keptBytes_ = 0;
};

/// Returns every n-th strip, from the middle of the first n on, so that they have about `most` texels.
std::vector<int> spreadStrips(const LightMapSource& source, std::int64_t most);

/// A texel of the bake.
struct BakedTexel {
    int x = 0, y = 0;
    lighting::ShRgb sh{};
    glm::vec3 normal{0};
};
/// Returns the covered texels of the 4 x 4 block whose first texel is (x, y).
formats::Result<std::vector<BakedTexel>> coveredOfBlock(LightMapSource& bake, int x, int y);

/// Fields of [[light_map]] as parameters of an action, and as the manifest states them.
template <class Fields, Is<formats::NodePlace> Self>
void describe(Fields& fields, Self& place) {
    fields.required("node", place.node, "name of the node, or the end of its path");
    fields.required("scale", place.scale, "factors of its light-map UVs");
    fields.required("offset", place.offset, "what is added to them then");
}

template <class Fields, Is<formats::LightMapDescription> Self>
void describe(Fields& fields, Self& description) {
    fields.required("bake", description.bake, "bake format of the file, or auto");
    fields.required("phase", description.phase, "sign convention of the SH basis");
    fields.required("frame", description.frame, "frame of the coefficients");
    fields.required("quantity", description.quantity, "radiance or irradiance");
    fields.required("light_units", description.lightUnits, "radiometric or game");
    fields.presentIf(description.encoding != formats::LightEncoding::Auto, "encoding", description.encoding,
                     "encoding of the colours of a picture of 8 or 16 bits");
    fields.presentIf(description.coverage != formats::CoverageSource::File, "coverage", description.coverage,
                     "what says which texels lie inside charts");
    fields.presentIf(!description.axes.isIdentity(), "axes", description.axes,
                     "components of the file's vectors that are x, y and z of the mesh; `x,y,z` if absent");
    fields.presentIf(!description.outputAxes.isIdentity(), "output_axes", description.outputAxes,
                     "components of a vector in the axes of the mesh that are x, y and z of the cooked map's; `x,y,z` if absent");
    fields.presentIf(description.hasNoLmbake, "no_lmbake", description.hasNoLmbake,
                     "true if the UVs of a bake of Godot are in the whole map already");
    fields.presentIf(!description.places.empty(), "places", description.places,
                     "nodes of the mesh that the map lies on, with their places in it; all if absent");
    fields.presentIf(!description.image.empty(), "image", description.image, "name of the image of a glTF that has several light maps");
    fields.presentIf(!description.parts.empty(), "files", description.parts,
                     "names of the images of a bake that has one for each coefficient, `sh00`, or for each colour, `sh00.R`");
    fields.presentIf(description.takesTangents, "tangents", description.takesTangents,
                     "true if normals and tangents are those of the mesh: for layouts in tangent space");
    fields.required("color_source", description.colors.source, "colour space of the file");
    fields.required("color_working", description.colors.working, "colour space of the cooked textures");
    fields.required("firefly_limit", description.fireflyLimit, "brightness over the neighbours at which a texel is a firefly; 0: none is");
    fields.required("repair", description.repair, "true if faults are repaired instead of refused");
    fields.optional("constant_of", description.constantOf, "width and height of a map whose texels all hold the same light");
}

/// Returns how the light map of a cooked asset is read.
formats::Result<formats::LightMapDescription> descriptionOf(const CookedAsset& asset);
/// Returns the inputs of an action that opens a light map, by role:
///   source       the file
///   source-NAME  each file that is read beside it: the images that the description lists, or those that the bake format finds
///   lmbake       of a bake of Godot: where the nodes of the mesh lie
///   frames       the mesh that a bake reads: of one in tangent space, or for its normals and coverage
/// and the configuration of its colours (isColorConfigRole).
std::map<std::string, std::filesystem::path> bakeInputs(const std::filesystem::path& file, const formats::LightMapDescription& description);
/// Returns the description with the files among the inputs of an action: the configuration of colours, and the images that it lists.
formats::LightMapDescription withFiles(formats::LightMapDescription description,
                                       const std::map<std::string, std::filesystem::path>& inputs);
/// Returns the size of these inputs [bytes].
std::uint64_t bakeBytes(const Action& action);
/// Opens the action's input "source". It stays open as long as the cook.
formats::Result<LightMapSource*> openLightMap(const ActionContext& context, formats::LightMapDescription description);

}  // namespace lightcook::pipeline
