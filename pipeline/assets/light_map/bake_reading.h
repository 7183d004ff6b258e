// The words of `info` and `lint` for the format that a light map was recognised as.
#pragma once

#include <string>
#include <vector>

#include "formats/light_map.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

struct BakeReading {
    std::string lightMap;  ///< name of the asset; of `info`, empty
    std::string bake, evidence;
    std::vector<std::string> assumed, otherReadings, incompleteSets;
};
template <class Fields, Is<BakeReading> Self>
void describe(Fields& fields, Self& reading) {
    fields.required("light_map", reading.lightMap, "name of the light map");
    fields.required("bake", reading.bake, "bake format that the file was read as");
    fields.required("evidence", reading.evidence, "what it was recognised by");
    fields.required("assumed", reading.assumed, "what the file does not say");
    fields.required("other_readings", reading.otherReadings, "bake formats that the file would fit as well");
    fields.required("incomplete_sets", reading.incompleteSets, "sets of files of which the file would be one, and others are missing");
}

/// The assumption for a file that does not say which texels lie inside charts.
inline constexpr const char* kEveryTexelIsCovered = "every texel is covered";
/// The assumption for a map with directions if neither its file nor a mesh has normals.
inline constexpr const char* kEverySurfaceFacesZ = "every surface faces +z";

/// Returns how an open file was recognised, without the name of the asset.
BakeReading readingOf(const formats::LightMapReader& map);
/// Returns the part of it that the header of a file says.
BakeReading readingOf(const formats::BakeRecognition& recognition);

}  // namespace lightcook::pipeline
