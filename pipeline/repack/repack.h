// lightcook repack: a bake and its meshes with the charts of the light map packed anew, and with fewer texels where the light is smooth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/light_map.h"
#include "pipeline/assets/light_map/chart_places.h"
#include "pipeline/graph/action.h"
#include "verify/visible.h"

namespace lightcook::pipeline {

struct RepackRequest {
    std::filesystem::path map;
    formats::LightMapDescription description;
    std::vector<std::filesystem::path> meshes;  ///< glTF files with light-map UVs (TEXCOORD_1) in the map
    std::filesystem::path lmbake = {};          ///< where the nodes of the meshes lie in the map; empty: where TEXCOORD_1 says
    std::filesystem::path folder;               ///< gets the bake as EXR and each mesh as GLB, by the names that they have
    double maxVisible = 1;                      ///< of 99 % of each chart's samples [Delta E ITP]; 0: charts are moved only
    /// The folder may hold files of the user. Those of an earlier repack, which kRepackedListName lists, are replaced; a file of another
    /// origin is refused.
    bool keepsOthers = false;
};

struct Repacked {
    std::filesystem::path map;
    std::vector<std::filesystem::path> meshes;
    glm::ivec2 sizeBefore{0}, size{0};      ///< [texels]
    std::int64_t readBefore = 0, read = 0;  ///< texels that filters read
    std::size_t charts = 0, reducedCharts = 0;
    verify::VisibleFigures visible = {};  ///< of exit radiance, against the bake (atlas/reduction.h says where)
    double relRms = 0;                    ///< of exit radiance, over the same samples
    std::vector<ChartPlace> places = {};  ///< of each chart, in the order of atlas::findCharts
    formats::LightMapRepairs repairs = {};
    std::int64_t negativeAfterGamut = 0;  ///< see formats::LightMapStrip
    std::string uvBefore = {};            ///< attribute of the first mesh with the UVs that it had

    Json toJson() const;
};

/// List of the files that repacks wrote into a folder, with RepackRequest::keepsOthers.
inline constexpr const char* kRepackedListName = "repacked.json";

/// Largest share of the covered texels of a bake that its meshes may leave unread.
inline constexpr double kMostUnread = 0.1;

/// Reads the bake, and writes the repacked one and its meshes. Charts stay where they are, with all of their texels, if the map would take
/// no fewer blocks otherwise. Nothing is written if it fails. Holds the bake in memory.
/// Fails with ErrorCode::WrongShape, naming mesh and triangle, for meshes without light-map UVs, UVs outside [0, 1], and meshes that do not
/// belong to the bake: they read charts without a covered texel, or leave more than kMostUnread of the covered texels unread.
/// Fails with ErrorCode::InvalidRequest for an output that would replace an input, or a file that `keepsOthers` protects.
/// action  that progress is reported for; null: one of its own
formats::Result<Repacked> repack(const RepackRequest& request, const RunState& state, const Action* action = nullptr);

}  // namespace lightcook::pipeline
