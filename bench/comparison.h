// Compares our encoders with peers on the same pixels in the same process, and draws the Pareto fronts.
//
// Method: for each format and class of picture, all encoders (each effort of ours, each profile of the peers) encode each picture in turn,
// for several rounds. So whatever else the machine does falls on all alike. The time of an encoder on a picture is the least processor time
// of its rounds. Blocks are decoded by the verifier.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bench/class_pictures.h"
#include "bench/figures.h"
#include "bench/peer_encoders.h"
#include "bench/scatter.h"

namespace lightcook::bench {

struct ComparisonOptions {
    std::vector<int> efforts = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
    /// Our encoders minimize the squared errors with these weights, and all encoders are judged by them. Unless all are 1, formats without
    /// colour are left out.
    std::array<float, 4> channelWeights = {1, 1, 1, 1};
    int rounds = 7;              ///< at most, for each encoder and picture
    double secondsEach = 0.5;    ///< an encoder that has taken this long on a picture takes part in no further round of it
    double secondsRound = 2e-3;  ///< an encoder repeats its work within a round up to this time
};

/// An encoder at one setting, on one picture.
struct ComparisonResult {
    std::string picture;
    double mpixPerCpuSecond = 0;
    Figures figures;
};

/// An encoder at one setting, on all pictures of a class.
struct ComparisonEntry {
    std::string encoder;  ///< "lightcook", or the name of a peer
    std::string profile;  ///< "5", or the name of a peer's profile
    bool isOurs = false;
    std::vector<ComparisonResult> results;  ///< in the order of the pictures
    double mpixPerCpuSecond = 0;            ///< all texels over the sum of the times
    double db = 0;                          ///< mean over the pictures
    bool isOnFront = false;                 ///< no other entry is as fast and as good, and better in one
};

struct Comparison {
    formats::PixelFormat format;
    PictureClass pictureClass;
    std::vector<ComparisonEntry> entries;  ///< ours by effort, then each peer's by profile
};

/// Marks the entries of the Pareto front: those that no other entry equals or beats in both speed and decibels, beating it in one.
void markFront(std::vector<ComparisonEntry>& entries);

/// Compares the encoders of a format on the pictures of each class that suits it. Formats that no peer encodes give nothing.
formats::Result<std::vector<Comparison>> compareEncoders(formats::PixelFormat format, std::span<const PeerEncoder> peers,
                                                         std::span<const ClassPicture> pictures, const ComparisonOptions& options);

/// Returns a panel for each comparison: ours, the peers, and the front.
std::string comparisonPage(std::span<const Comparison> comparisons, std::span<const ClassPicture> pictures);

/// Returns the same as JSON, with the figures of each picture.
std::string comparisonJson(std::span<const Comparison> comparisons);

/// Prints the entries of a comparison as a table.
void printComparison(const Comparison& comparison);

}  // namespace lightcook::bench
