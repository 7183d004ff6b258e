#include "pipeline/assets/light_map/bake_reading.h"

namespace lightcook::pipeline {

BakeReading readingOf(const formats::BakeRecognition& recognition) {
    BakeReading reading;
    reading.bake = recognition.format->name;
    reading.evidence = recognition.evidence;
    if (!recognition.format->assumes.empty()) reading.assumed.emplace_back(recognition.format->assumes);
    reading.otherReadings.assign(recognition.otherReadings.begin(), recognition.otherReadings.end());
    reading.incompleteSets = recognition.incompleteSets;
    return reading;
}

BakeReading readingOf(const formats::LightMapReader& map) {
    BakeReading reading = readingOf(map.recognition());
    if (!map.hasCoverage()) reading.assumed.emplace_back(kEveryTexelIsCovered);
    if (!map.hasNormals() && map.hasDirections()) reading.assumed.emplace_back(kEverySurfaceFacesZ);
    return reading;
}

}  // namespace lightcook::pipeline
