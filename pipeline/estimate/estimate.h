// lightcook estimate: what the light maps of meshes cost, before any bake: their pages, memory and time of a cook, from light-map UVs and
// a density of texels alone.
//
// Method. A surface is a triangle primitive as a node draws it. If the surfaces of different nodes hardly share texels, all UVs are those
// of one image; else each node has an image of its own, as engines give it at an import. An image is as large as its density asks on
// average: side = density * sqrt(area in the world / area of the UVs). Images of nodes are packed into pages (atlas/pages.h). Surfaces
// without light-map UVs count by their area in the world alone, which is the least that any UVs need.
//
// Charts (atlas/charts.h) and shared texels (lint/uv_raster.h) are found at the size of the image, or at that of the largest page for an
// image beyond it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/light_map_layout.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

struct EstimateOptions {
    std::vector<std::filesystem::path> meshes;  ///< glTF files
    double texelDensity = 0;                    ///< texels for a unit of length of the scene
    int padding = 2;                            ///< texels between charts, and between images
    int largestPage = 4096;                     ///< side [texels], a multiple of atlas::kPageStep
    formats::Target target = formats::Target::Bc;
    std::optional<formats::LightMapLayout> layout;  ///< none: any
    std::optional<std::uint64_t> budgetBytes;       ///< of all pages
    std::filesystem::path rates;                    ///< the file of WorkRates
};

inline constexpr int kLargestPage = 16384;

/// What light-map UVs are places in.
enum class UvUse {
    Shared,  ///< one image of all nodes
    Each,    ///< an image for each node
};
template <>
struct EnumNames<UvUse> {
    static std::vector<std::string> all() { return {"shared", "each"}; }
};

/// A page of light maps.
struct EstimatedPage {
    int width = 0, height = 0;  ///< [texels]
};
template <class Fields, Is<EstimatedPage> Self>
void describe(Fields& fields, Self& page) {
    fields.required("width", page.width, "width [texels]");
    fields.required("height", page.height, "height [texels]");
}

/// A node; of meshes that a single node draws, one of its primitives.
struct EstimatedPart {
    std::string name;
    double area = 0;                     ///< in the world
    std::optional<double> density = {};  ///< none: without light-map UVs
    std::optional<int> side = {};        ///< of its image
    std::int64_t texels = 0;             ///< that filters read
    std::int64_t paddingTexels = 0;      ///< around its charts
    std::int64_t sharedTexels = 0;
    std::int64_t charts = 0, smallCharts = 0;
};
template <class Fields, Is<EstimatedPart> Self>
void describe(Fields& fields, Self& part) {
    fields.required("name", part.name, "file and node; of meshes that a single node draws, its primitive");
    fields.required("area", part.area, between(0, HUGE_VAL), "surface in the world [square units]");
    fields.optional("density", part.density, between(0, HUGE_VAL),
                    "texels for a unit of length, on average; absent without light-map UVs, where the area alone counts");
    fields.optional("side", part.side, "side of the image of its own [texels]; absent if all share one");
    fields.required("texels", part.texels, "texels that filters read");
    fields.required("padding_texels", part.paddingTexels, "texels of the padding of its charts");
    fields.required("shared_texels", part.sharedTexels, "texels that two triangles read, of which this part has the second one");
    fields.required("charts", part.charts, "charts that begin in it");
    fields.required("small_charts", part.smallCharts, "of these, charts whose padding takes more texels than they do");
}

/// Memory and time of all pages in one layout.
struct EstimatedLayout {
    std::string layout;
    double bitsPerTexel = 0;
    std::uint64_t bytesGpu = 0;  ///< of a learned layout with the most that its tables take
    double seconds = 0;          ///< of cooking and verifying all pages, one after the other
    bool isMeasuredHere = false;
    std::optional<bool> passed = {};
};
template <class Fields, Is<EstimatedLayout> Self>
void describe(Fields& fields, Self& layout) {
    fields.required("layout", layout.layout, "layout of the light maps");
    fields.required("bits_per_texel", layout.bitsPerTexel, between(0, HUGE_VAL), "GPU memory of a texel of the pages [bits]");
    fields.required("bytes_gpu", layout.bytesGpu, "GPU memory [bytes]; of a learned layout with the most that its tables take");
    fields.required("seconds", layout.seconds, between(0, HUGE_VAL), "time to cook and to verify all pages");
    fields.required("measured_here", layout.isMeasuredHere,
                    "true if the time is that of the last cook with this layout on this machine; else it is that of a server with two "
                    "cores");
    fields.optional("passed", layout.passed, "true if it is within the budget; absent without one");
}

struct Estimate {
    double texelDensity = 0;
    int padding = 0, largestPage = 0;
    formats::Target target = formats::Target::Bc;
    UvUse uvs = UvUse::Shared;
    std::vector<EstimatedPage> pages = {};
    std::int64_t texels = 0;         ///< of all pages
    std::int64_t readTexels = 0;     ///< of these, texels that filters read
    std::int64_t paddingTexels = 0;  ///< around charts
    std::int64_t withoutUvs = 0;     ///< surfaces
    double trialSeconds = 0;         ///< of layout "auto", before it cooks
    bool isTrialMeasuredHere = false;
    std::vector<EstimatedPart> parts = {};  ///< the one with most texels first
    std::vector<EstimatedLayout> layouts = {};
    std::optional<std::uint64_t> budgetBytes = {};
    std::vector<formats::Error> errors = {};  ///< images beyond the largest page; a budget that nothing keeps. Not in JSON
};
template <class Fields, Is<Estimate> Self>
void describe(Fields& fields, Self& estimate) {
    fields.required("texel_density", estimate.texelDensity, between(0, HUGE_VAL), "texels for a unit of length, as asked");
    fields.required("padding", estimate.padding, "texels between charts, and between images");
    fields.required("largest_page", estimate.largestPage, "largest side of a page [texels]");
    fields.required("target", estimate.target, "family of GPU formats");
    fields.required("uvs", estimate.uvs, "what light-map UVs are places in: one image of all nodes, or one of each");
    fields.required("pages", estimate.pages, "pages of light maps");
    fields.required("texels", estimate.texels, "texels of all pages");
    fields.required("read_texels", estimate.readTexels, "texels that filters read");
    fields.required("padding_texels", estimate.paddingTexels, "texels of the padding of charts");
    fields.required("without_uvs", estimate.withoutUvs, "surfaces without light-map UVs, which count by their area");
    fields.required("trial_seconds", estimate.trialSeconds, between(0, HUGE_VAL), "time that layout auto takes to choose, before it cooks");
    fields.required("trial_measured_here", estimate.isTrialMeasuredHere, "true if that time was measured on this machine");
    fields.required("parts", estimate.parts, "parts of the meshes, the one with most texels first");
    fields.required("layouts", estimate.layouts, "memory and time by layout");
    fields.optional("budget_bytes", estimate.budgetBytes, "GPU memory of all pages, as asked [bytes]");
}

/// Estimates the light maps of meshes.
/// Fails for files that cannot be read, scenes that draw no triangle, and light-map UVs outside [0, 1].
formats::Result<Estimate> estimateLightMaps(const EstimateOptions& options, const RunState& state);

}  // namespace lightcook::pipeline
