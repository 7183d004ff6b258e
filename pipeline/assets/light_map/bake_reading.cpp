#include "pipeline/assets/light_map/bake_reading.h"

namespace lightcook::pipeline {

BakeReading readingOf(const formats::LightMapReader& map) {
    const formats::BakeRecognition& recognition = map.recognition();
    BakeReading reading;
    reading.bake = recognition.format->name;
    reading.evidence = recognition.evidence;
    if (!recognition.format->assumes.empty()) reading.assumed.emplace_back(recognition.format->assumes);
    if (!map.hasCoverage()) reading.assumed.emplace_back("every texel is covered");
    reading.otherReadings.assign(recognition.otherReadings.begin(), recognition.otherReadings.end());
    return reading;
}

}  // namespace lightcook::pipeline
