// Compares our encoders with peers on the same pixels in the same process, and draws the Pareto fronts.
//
// Method: for each format and class of picture, all encoders (each effort of ours, each profile of the peers) encode each picture in turn,
// for several rounds, so that other load on the machine affects all of them alike. The time of an encoder on a picture is the least
// processor time of its rounds. Blocks are decoded by the verifier.
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
    /// Our encoders minimize the squared errors with these weights, and the figures of all encoders use them. Unless all are 1, formats
    /// without colour are left out.
    std::array<float, 4> channelWeights = {1, 1, 1, 1};
    int rounds = 7;              ///< maximum number of rounds for each encoder and picture
    double secondsEach = 0.5;    ///< an encoder that has taken this long on a picture skips its further rounds
    double secondsRound = 2e-3;  ///< an encoder repeats its work within a round until it has taken this long
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
    bool isOnFront = false;                 ///< see markFront()
};

struct Comparison {
    formats::PixelFormat format;
    PictureClass pictureClass;
    std::vector<ComparisonEntry> entries;  ///< ours by effort, then each peer's by profile
};

/// Marks the entries of the Pareto front: those that no other entry equals or beats in both speed and decibels, beating it in one.
void markFront(std::vector<ComparisonEntry>& entries);

/// Compares the encoders of a format on the pictures of each class that suits it. Returns none for a format that no peer encodes.
formats::Result<std::vector<Comparison>> compareEncoders(formats::PixelFormat format, std::span<const PeerEncoder> peers,
                                                         std::span<const ClassPicture> pictures, const ComparisonOptions& options);

/// Returns an HTML page with a panel for each comparison: our encoder, the peers, and the Pareto front.
std::string comparisonPage(std::span<const Comparison> comparisons, std::span<const ClassPicture> pictures);

/// Returns the comparisons as JSON, with the figures of each picture.
std::string comparisonJson(std::span<const Comparison> comparisons);

/// Prints the entries of a comparison as a table.
void printComparison(const Comparison& comparison);

}  // namespace lightcook::bench
