// lightcook_encoder_bench: run time against error of every encoder at every effort, as a table, as CSV and as a page of scatter plots.
// --peers DIR runs the encoders of shared objects beside ours. --table writes the quality table that tests/quality compares encoders with.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <stdexcept>

#include "bench/class_pictures.h"
#include "bench/comparison.h"
#include "bench/markdown_table.h"
#include "bench/or_throw.h"
#include "bench/output_file.h"
#include "bench/peer_encoders.h"
#include "bench/quality_table.h"
#include "bench/scatter.h"
#include "bench/timing.h"
#include "compress/encode_options.h"

namespace lightcook::bench {
namespace {

using formats::PixelFormat;

struct Options {
    std::filesystem::path data = LIGHTCOOK_SHARED_DATA, csv, html, table, peers, photographs, json;
    std::vector<std::string> formats = {"bc1",          "bc3",          "bc4",          "bc5",          "bc6h-uf16", "bc6h-sf16", "bc7",
                                        "astc-4x4-hdr", "astc-6x6-hdr", "astc-8x8-hdr", "astc-4x4-ldr", "rgb9e5",    "r11g11b10f"};
    std::vector<int> efforts = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
    std::vector<std::string> images;  ///< only pictures whose name contains one of these; empty: all
    double seconds = 2;               ///< time limit for a picture [s]
    std::string instructions = "best";
    bool own = false;         ///< pictures of the repository, not of the shared data
    bool perceptual = false;  ///< with peers: the channel weights of kLumaWeights
};

struct Row {
    PixelFormat format;
    int effort;
    const Picture* picture;
    Timing timing;
};

/// Means over rows. Seconds are those of one thread (processor time) and of two threads (wall clock).
struct Mean {
    double secondsPerMpix = 0, secondsPerMpix2 = 0, db = 0, relRmse = 0, share = 0;

    explicit Mean(const std::vector<const Row*>& rows) {
        double texels = 0, cpu = 0, wall = 0;
        for (const Row* row : rows) {
            const auto size = static_cast<double>(row->picture->texels.texels().size());
            texels += size;
            cpu += size / row->timing.mpixPerCpuSecond;
            wall += size / row->timing.mpixPerSecond2;
            db += row->timing.wholeDb;
            relRmse += row->timing.figures.relRmse;
            share += size * row->timing.share;
        }
        const auto count = static_cast<double>(rows.size());
        secondsPerMpix = cpu / texels, secondsPerMpix2 = wall / texels, share /= texels;
        db /= count, relRmse /= count;
    }
};

/// Prints the head of the table of one format; the rows follow, one for each effort.
void printHead(PixelFormat format, const std::vector<const Picture*>& pictures) {
    fmt::print("\n{}\n\n", formats::info(format).name);
    std::vector<std::string> titles = {">effort", ">Mpix/s", ">two threads", ">share"};
    for (const Picture* picture : pictures) titles.push_back(">" + picture->name);
    titles.insert(titles.end(), {">mean dB", ">rel RMSE"});
    printTableHead(titles);
}
void printRow(int effort, const std::vector<const Row*>& rows) {
    const Mean mean(rows);
    std::vector<std::string> cells = {std::to_string(effort), threeDigits(1 / mean.secondsPerMpix), threeDigits(1 / mean.secondsPerMpix2),
                                      fmt::format("{:.0f} %", std::max(1.0, 100 * mean.share))};
    for (const Row* row : rows) cells.push_back(fmt::format("{:.2f}", row->timing.wholeDb));
    cells.push_back(fmt::format("{:.3f}", mean.db));
    cells.push_back(fmt::format("{:.4f}", mean.relRmse));
    printTableRow(cells);
}

std::string csvOf(const std::vector<Row>& rows) {
    std::string text =
        "format,effort,picture,kind,share,texels,mpix_per_cpu_s_1_thread,mpix_per_s_2_threads,psnr_db_of_whole,psnr_db,log_rmse,rel_rmse,"
        "p99_relative,max_relative\n";
    for (const Row& row : rows) {
        const Timing& t = row.timing;
        const Figures& f = t.figures;
        text += fmt::format("{},{},{},{},{:.4f},{},{:.5g},{:.5g},{:.4f},{:.4f},{:.6g},{:.6g},{:.6g},{:.6g}\n",
                            formats::info(row.format).name, row.effort, row.picture->name, nameOf(row.picture->kind), t.share, f.texels,
                            t.mpixPerCpuSecond, t.mpixPerSecond2, t.wholeDb, f.psnrDb, f.logRmse, f.relRmse, f.p99Relative, f.maxRelative);
    }
    return text;
}

/// A BC6H encoder of another project, as the targets of this project quote it: measured elsewhere, with one thread and AVX-512.
struct Quoted {
    const char* name;
    double mpixPerSecond;
    std::optional<double> samePicturesDb;  ///< mean over the four panoramas and the four padded light maps, if it was measured
    double otherPicturesDb;                ///< mean over nine other pictures
};
constexpr double meanOf(std::initializer_list<double> values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}
const Quoted kQuoted[] = {
    // name, Mpix/s, dB of panoramas and of light maps, dB of nine other pictures
    {"ISPC veryfast", 150, meanOf({37.680, 46.076, 43.910, 37.708, 47.16, 36.78, 43.14, 38.25}), 41.23},
    {"ISPC fast", 15.5, meanOf({40.541, 47.173, 45.520, 40.176, 50.73, 39.11, 46.57, 39.14}), 43.20},
    {"ISPC basic", 6.2, meanOf({40.727, 47.689, 45.672, 40.663, 51.26, 39.92, 47.69, 39.80}), 43.52},
    {"ISPC slow", 1.35, meanOf({40.806, 47.849, 45.795, 40.807, 51.21, 39.90, 47.78, 39.97}), 43.68},
    {"ISPC veryslow", 0.63, meanOf({40.826, 47.883, 45.807, 40.828, 51.10, 39.92, 47.70, 40.00}), 43.72},
    {"DirectXTex", 0.0066, std::nullopt, 43.09},
    {"CMP_Core 0.05", 0.37, std::nullopt, 41.62},
    {"CMP_Core 0.5", 0.22, std::nullopt, 41.63},
    {"basisu UASTC HDR 0", 1.7, std::nullopt, 40.15},
    {"basisu UASTC HDR 2", 0.125, std::nullopt, 41.53},
};

/// Adds the quoted encoders to a panel.
/// hasSamePictures  the panel is of the panoramas and light maps of Quoted::samePicturesDb
void addQuoted(bool hasSamePictures, ScatterPanel& panel) {
    ScatterSeries same{"quoted, not run here: same pictures", ScatterSeries::Style::Quoted, {}};
    ScatterSeries other{"quoted, not run here: nine other pictures", ScatterSeries::Style::QuotedElsewhere, {}};
    for (const Quoted& each : kQuoted) {
        const bool isSame = hasSamePictures && each.samePicturesDb;
        const double db = isSame ? *each.samePicturesDb : each.otherPicturesDb;
        (isSame ? same : other)
            .points.push_back({1 / each.mpixPerSecond, db, each.name,
                               fmt::format("{}, quoted, not run here: {} Mpix/s, {:.2f} dB", each.name, each.mpixPerSecond, db)});
    }
    if (!same.points.empty()) panel.series.push_back(std::move(same));
    panel.series.push_back(std::move(other));
}

ScatterSeries seriesOf(const std::string& name, ScatterSeries::Style style, const std::map<int, std::vector<const Row*>>& byEffort) {
    ScatterSeries series{name, style, {}};
    for (const auto& [effort, rows] : byEffort) {
        const Mean mean(rows);
        series.points.push_back(
            {mean.secondsPerMpix, mean.db, style == ScatterSeries::Style::Main ? std::to_string(effort) : "",
             fmt::format("effort {}, {}: {} Mpix/s ({} with two threads), {:.3f} dB, rel RMSE {:.4f}{}", effort, name,
                         threeDigits(1 / mean.secondsPerMpix), threeDigits(1 / mean.secondsPerMpix2), mean.db, mean.relRmse,
                         mean.share < 0.999 ? fmt::format(", on {:.1f} % of the texels", 100 * mean.share) : "")});
    }
    return series;
}

ScatterPanel panelOf(PixelFormat format, const std::vector<Row>& rows, bool hasSamePictures) {
    std::map<int, std::vector<const Row*>> all;
    std::map<PictureKind, std::map<int, std::vector<const Row*>>> kinds;
    for (const Row& row : rows)
        if (row.format == format) {
            all[row.effort].push_back(&row);
            kinds[row.picture->kind][row.effort].push_back(&row);
        }
    const bool isFloat = formats::info(format).isFloat;
    ScatterPanel panel{std::string(formats::info(format).name), isFloat ? "log2-PSNR, dB" : "PSNR, dB", {}};
    panel.series.push_back(seriesOf("mean of all pictures", ScatterSeries::Style::Main, all));
    if (kinds.size() > 1)
        for (const auto& [kind, byEffort] : kinds)
            panel.series.push_back(seriesOf(std::string(nameOf(kind)), ScatterSeries::Style::Part, byEffort));
    if (format == PixelFormat::Bc6hUf16) addQuoted(hasSamePictures, panel);
    return panel;
}

/// Keeps the pictures of option --images. Throws if none is left.
template <class AnyPicture>
void keepImages(const Options& options, std::vector<AnyPicture>& pictures) {
    std::erase_if(pictures, [&](const AnyPicture& picture) {
        return !options.images.empty() && std::none_of(options.images.begin(), options.images.end(), [&](const std::string& part) {
            return picture.name.find(part) != std::string::npos;
        });
    });
    if (pictures.empty()) throw std::runtime_error("--images: no picture has a name that contains one of these");
}

std::vector<Picture> picturesFor(const Options& options) {
    std::vector<Picture> pictures;
    if (!options.own) pictures = sharedPictures(options.data);
    if (pictures.empty()) {
        if (!options.own) fmt::print("no shared data in {}: pictures of the repository's own\n", options.data.string());
        pictures = ownPictures(LIGHTCOOK_SOURCE_DIR, 256);
    }
    keepImages(options, pictures);
    return pictures;
}

std::vector<PixelFormat> formatsOf(const std::vector<std::string>& names) {
    std::vector<PixelFormat> found;
    for (const std::string& name : names) {
        const auto format = formats::pixelFormatFromName(name);
        if (!format)
            throw std::runtime_error(fmt::format("--formats: '{}' is no format; `lightcook encode --format` has their names", name));
        found.push_back(*format);
    }
    return found;
}

/// Returns true if the pictures include the four panoramas and four light maps of the quoted figures.
bool hasQuotedPictures(const std::vector<Picture>& pictures) {
    const auto count = [&](PictureKind kind) {
        return std::count_if(pictures.begin(), pictures.end(), [kind](const Picture& picture) { return picture.kind == kind; });
    };
    return count(PictureKind::Panorama) == 4 && count(PictureKind::LightMap) == 4;
}

void measureAll(const Options& options) {
    const std::vector<PixelFormat> formats_ = formatsOf(options.formats);
    const std::vector<Picture> pictures = picturesFor(options);
    std::vector<Row> rows;
    for (const PixelFormat format : formats_) {
        std::vector<const Picture*> suited;
        for (const Picture& picture : pictures)
            if (suits(picture, format)) suited.push_back(&picture);
        if (suited.empty()) continue;
        printHead(format, suited);
        // Formats without blocks have no effort: the first stands for all.
        const bool hasEffort = formats::info(format).blockWidth > 1;
        std::map<const Picture*, Control> controls;
        for (std::size_t i = 0; i < (hasEffort ? options.efforts.size() : 1); ++i) {
            const std::size_t first = rows.size();
            const int effort = options.efforts[i];
            for (const Picture* picture : suited) {
                const auto found = controls.find(picture);
                const auto control = found == controls.end() ? std::nullopt : std::optional(found->second);
                rows.push_back({format, effort, picture, timeEncoder(format, effort, *picture, options.seconds, control)});
                if (rows.back().timing.share == 1) controls[picture] = {effort, rows.back().timing.wholeDb};
            }
            std::vector<const Row*> fresh;
            for (std::size_t k = first; k < rows.size(); ++k) fresh.push_back(&rows[k]);
            printRow(effort, fresh);
        }
    }
    if (!options.csv.empty()) writeOutput(options.csv, csvOf(rows));
    if (options.html.empty()) return;
    std::vector<ScatterPanel> panels;
    for (const PixelFormat format : formats_)
        if (std::any_of(rows.begin(), rows.end(), [format](const Row& row) { return row.format == format; }))
            panels.push_back(panelOf(format, rows, hasQuotedPictures(pictures)));
    std::string names;
    for (const Picture& picture : pictures) names += (names.empty() ? "" : ", ") + picture.name;
    writeOutput(
        options.html,
        scatterPage("Block encoders: run time against error",
                    {"Numbers at points are efforts, 0 fastest to 9 best. Further up is better, further left is faster. "
                     "Time is processor time of one thread; "
                     "decoding for the error is by the verifier's own decoders.",
                     "Float formats: 20 log10(1 / rms(log2(1+x') - log2(1+x))). Others: PSNR of (x / (1 + x))^(1/2.2), "
                     "alpha made from the colour. Light maps inside charts.",
                     fmt::format("Slow efforts encode evenly spread blocks, about {} s a picture; what they gain there over the slowest "
                                 "effort that encoded the whole is taken for what they gain on the whole. Hollow marks are "
                                 "quoted from the project's targets and were not run here.",
                                 options.seconds),
                     "Pictures: " + names + "."},
                    panels));
}

/// Side of the pictures on which encoders are compared [texels]. The slowest encoder takes seconds for all of them.
constexpr int kComparisonSide = 4 * kPictureTile;

std::vector<ClassPicture> classPicturesFor(const Options& options) {
    std::vector<ClassPicture> pictures;
    if (!options.photographs.empty())
        pictures = photographsOf(options.photographs, kComparisonSide);
    else if (!options.own)
        pictures = sharedClassPictures(options.data, LIGHTCOOK_SOURCE_DIR, kComparisonSide);
    if (pictures.empty()) pictures = ownClassPictures(LIGHTCOOK_SOURCE_DIR, kComparisonSide);
    keepImages(options, pictures);
    return pictures;
}

std::vector<std::string> namesOfTableFormats() {
    std::vector<std::string> names;
    for (const PixelFormat format : tableFormats()) names.emplace_back(formats::info(format).name);
    return names;
}

void compareWithPeers(const Options& options) {
    const std::vector<PixelFormat> formats_ = formatsOf(options.formats);
    const std::vector<PeerEncoder> peers = orThrow(loadPeerEncoders(options.peers));
    const std::vector<ClassPicture> pictures = classPicturesFor(options);
    ComparisonOptions comparison;
    comparison.efforts = options.efforts;
    comparison.secondsEach = options.seconds;
    if (options.perceptual) comparison.channelWeights = compress::kLumaWeights;
    std::vector<Comparison> all;
    for (const PixelFormat format : formats_) {
        std::vector<Comparison> fresh = orThrow(compareEncoders(format, peers, pictures, comparison));
        for (Comparison& each : fresh) {
            printComparison(each);
            all.push_back(std::move(each));
        }
    }
    if (all.empty())
        throw std::runtime_error(options.peers.string() +
                                 ": the peers encode none of these formats for these pictures; name one that they do with --formats");
    if (!options.html.empty()) writeOutput(options.html, comparisonPage(all, pictures));
    if (!options.json.empty()) writeOutput(options.json, comparisonJson(all));
}

void writeTable(const std::filesystem::path& file) {
    const std::vector<Picture> pictures = ownPictures(LIGHTCOOK_SOURCE_DIR, kTablePictureSize);
    std::vector<QualityRow> rows;
    for (const PixelFormat format : tableFormats()) {
        double before = 0;
        for (int effort = 0; effort <= 9; ++effort) {
            const std::vector<QualityRow> fresh = qualityRows(format, effort, pictures);
            const double mean = meanDb(fresh);
            fmt::print("{} effort {}: {:.4f} dB{}\n", formats::info(format).name, effort, mean,
                       effort > 0 && mean <= before ? ", no better than the effort before" : "");
            std::fflush(stdout);
            before = mean;
            rows.insert(rows.end(), fresh.begin(), fresh.end());
        }
    }
    writeOutput(file, csvOf(rows));
}

}  // namespace
}  // namespace lightcook::bench

int main(int argumentCount, char** arguments) {
    lightcook::bench::Options options;
    bool quick = false;
    CLI::App app("Speed and error of the encoders at each effort: as tables, CSV and a page of scatter plots.");
    app.add_option("--formats", options.formats, "formats to measure; names of `lightcook encode --format`")->delimiter(',');
    app.add_option("--efforts", options.efforts, "efforts to measure, 0 to 9")->delimiter(',')->check(CLI::Range(0, 9));
    app.add_option("--images", options.images, "measure only pictures whose name contains one of these")->delimiter(',');
    app.add_option("--seconds", options.seconds, "time limit for a picture; slower efforts encode a share of its blocks")
        ->check(CLI::Range(0.01, 1e6));
    app.add_flag("--quick", quick, "0.2 seconds a picture; efforts 0, 1, 3, 5, 7, 9 by default");
    app.add_option("--instructions", options.instructions, "vector instructions that our encoders may use")
        ->check(CLI::IsMember({"best", "avx2"}));
    app.add_flag("--own", options.own, "use the pictures of the repository, even if the shared data are present");
    app.add_option("--data", options.data, "folder of the shared data");
    CLI::Option* const peers =
        app.add_option("--peers", options.peers, "run the encoders of the shared objects in this folder beside ours, on the same pixels");
    app.add_option("--photographs", options.photographs, "with --peers: measure on the pictures of this folder")
        ->needs(peers)
        ->check(CLI::ExistingDirectory);
    app.add_option("--json", options.json, "with --peers: write all figures to this file")->needs(peers);
    app.add_flag(
           "--perceptual", options.perceptual,
           "with --peers: our encoders weigh channels as the luma of BT.709 does (`lightcook encode --perceptual`), and decibels are of "
           "errors with these weights; formats of colour alone")
        ->needs(peers);
    app.add_option("--csv", options.csv, "write a row for each format, effort and picture to this file")->excludes(peers);
    app.add_option("--html", options.html, "write the scatter plots to this page");
    app.add_option("--table", options.table, "write only the quality table of tests/quality to this file")->excludes(peers);
    CLI11_PARSE(app, argumentCount, arguments);
    if (quick) {
        if (app.count("--seconds") == 0) options.seconds = 0.2;
        if (app.count("--efforts") == 0) options.efforts = {0, 1, 3, 5, 7, 9};
    }
    std::sort(options.efforts.begin(), options.efforts.end());
    if (options.instructions == "avx2") lightcook::compress::allowInstructionSet(lightcook::compress::InstructionSet::Avx2);
    try {
        if (!options.peers.empty() && app.count("--formats") == 0) options.formats = lightcook::bench::namesOfTableFormats();
        if (!options.peers.empty())
            lightcook::bench::compareWithPeers(options);
        else if (options.table.empty())
            lightcook::bench::measureAll(options);
        else
            lightcook::bench::writeTable(options.table);
    } catch (const std::exception& error) {
        fmt::print(stderr, "lightcook_encoder_bench: {}\n", error.what());
        return 1;
    }
    return 0;
}
