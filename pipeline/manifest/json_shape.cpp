#include "pipeline/manifest/json_shape.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::Result;

constexpr int kDeepest = 64;  ///< ours end at 8
constexpr std::int64_t kLargestSide = 1 << 20;
constexpr std::int64_t kLargestCount = 4096;           ///< of views and normals shaded, mips, layers
constexpr std::int64_t kLargestSampleCount = 1000000;  ///< as the command line takes
constexpr std::uint64_t kLargestBytes = std::uint64_t{1} << 60;

/// Thrown inside this file only: the first mistake ends a check.
struct Mistake {
    formats::Error error;
};

std::string shortened(const Json& value) {
    std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

/// A value and where it stands.
class Place {
public:
    Place(const Json& value, std::string subject, std::string path = "")
        : value_(value), subject_(std::move(subject)), path_(std::move(path)) {}

    [[noreturn]] void fail(const std::string& expected) const {
        throw Mistake{{ErrorCode::FileUnreadable, path_.empty() ? subject_ : subject_ + ", " + path_,
                       fmt::format("found {}, expected {}", shortened(value_), expected)}};
    }
    bool has(const char* key) const { return value_.is_object() && value_.contains(key); }
    Place operator[](const char* key) const {
        if (!value_.is_object()) fail("an object");
        const auto found = value_.find(key);
        if (found == value_.end()) fail(fmt::format("an object with a member \"{}\"", key));
        return {*found, subject_, path_.empty() ? key : path_ + "/" + key};
    }
    template <class Visit>
    void each(Visit visit) const {
        if (!value_.is_array()) fail("a list");
        std::size_t index = 0;
        for (const Json& element : value_) visit(Place(element, subject_, fmt::format("{}/{}", path_, index++)));
    }
    template <class Visit>
    void eachMember(Visit visit) const {
        object();
        for (const auto& [key, element] : value_.items()) visit(Place(element, subject_, path_ + "/" + key));
    }

    void object() const {
        if (!value_.is_object()) fail("an object");
    }
    void list(std::size_t least) const {
        if (!value_.is_array() || value_.size() < least) fail(fmt::format("a list of at least {}", least));
    }
    void flag() const {
        if (!value_.is_boolean()) fail("true or false");
    }
    const std::string& text() const {
        if (!value_.is_string()) fail("a string");
        return value_.get_ref<const std::string&>();
    }
    void oneOf(std::initializer_list<const char*> names) const {
        for (const char* name : names)
            if (value_ == name) return;
        fail(fmt::format("one of: {}", fmt::join(names, ", ")));
    }
    void number(double low, double high) const {
        if (!value_.is_number() || !(value_.get<double>() >= low && value_.get<double>() <= high))
            fail(fmt::format("a number from {} to {}", low, high));
    }
    void integer(std::int64_t low, std::int64_t high) const {
        const bool fits = value_.is_number_unsigned()
                              ? value_.get<std::uint64_t>() <= static_cast<std::uint64_t>(high) &&
                                    (low <= 0 || value_.get<std::uint64_t>() >= static_cast<std::uint64_t>(low))
                              : value_.is_number_integer() && value_.get<std::int64_t>() >= low && value_.get<std::int64_t>() <= high;
        if (!fits) fail(fmt::format("an integer from {} to {}", low, high));
    }
    void bytes() const { integer(0, static_cast<std::int64_t>(kLargestBytes)); }
    void bytesOrNull() const {
        if (!value_.is_null()) bytes();
    }
    /// A figure that may not be finite, which JSON writes as null.
    void figure() const {
        if (!value_.is_null()) number(0, HUGE_VAL);
    }
    /// A file inside the cooked folder.
    void file() const {
        const std::filesystem::path path = text();
        bool isInside = !path.empty() && path.is_relative() && path.has_filename() && text().find('\0') == std::string::npos;
        for (const auto& part : path) isInside = isInside && part != "..";
        if (!isInside) fail("the name of a file inside the cooked folder");
    }

private:
    const Json& value_;
    std::string subject_, path_;
};

void checkKind(const Place& kind) {
    kind.oneOf({"light-map", "dominant", "cubemap", "lut", "rsrm", "mesh"});
}

void checkTexture(const Place& texture) {
    for (const char* key : {"role", "format", "digest"}) texture[key].text();
    texture["file"].file();
    for (const char* key : {"width", "height"}) texture[key].integer(1, kLargestSide);
    for (const char* key : {"mips", "layers", "faces"}) texture[key].integer(1, kLargestCount);
    for (const char* key : {"bytes_gpu", "bytes_disk"}) texture[key].bytes();
}

void checkVerifyParameters(const Place& parameters) {
    parameters["max_error"].number(0, 1e30);
    if (parameters.has("samples")) parameters["samples"].integer(0, kLargestSampleCount);
    if (!parameters.has("shading")) return;
    const Place shading = parameters["shading"];
    shading["specular"].flag();
    for (const char* key : {"views", "normals"}) shading[key].integer(1, kLargestCount);
    for (const char* key : {"m", "f0"}) {
        shading[key].list(1);
        shading[key].each([](const Place& value) { value.number(0, 1); });
    }
}

void checkManifestAsset(const Place& asset) {
    for (const char* key : {"name", "layout"}) asset[key].text();
    checkKind(asset["kind"]);
    for (const char* key : {"width", "height"}) asset[key].integer(0, kLargestSide);
    asset["textures"].each(checkTexture);
    if (asset.has("file")) {
        asset["file"].file();
        asset["digest"].text();
    }
    for (const char* key : {"bytes_gpu", "bytes_disk"})
        if (asset.has(key)) asset[key].bytes();
    if (asset.has("basis"))
        for (const char* key : {"attribute", "light_map"}) asset["basis"][key].text();
    if (asset.has("fit")) asset["fit"].oneOf({"closed", "refined", "explained", "refined-ambient"});
    checkVerifyParameters(asset["verify"]);
    asset["source"]["files"].eachMember([](const Place& source) {
        source["file"].text();
        source["digest"].text();
    });
    // What the verification of each kind opens.
    const std::string& kind = asset["kind"].text();
    if (kind != "lut") asset["source"]["files"]["source"].object();
    if (kind == "mesh") {
        asset["source"]["files"]["mesh"].object();
        asset["file"].file();
    }
}

void checkReportFile(const Place& file) {
    file["file"].file();
    file["digest"].text();
}

void checkReportAsset(const Place& asset) {
    for (const char* key : {"name", "layout"}) asset[key].text();
    checkKind(asset["kind"]);
    for (const char* key : {"width", "height"}) asset[key].integer(0, kLargestSide);
    for (const char* key : {"bytes_in", "bytes_gpu", "bytes_disk"}) asset[key].bytes();
    for (const char* key : {"bits_per_texel", "seconds"}) asset[key].number(0, HUGE_VAL);
    asset["stages"].list(1);
    asset["stages"].each([](const Place& stage) {
        stage["name"].text();
        for (const char* kind : {"diffuse", "specular"})
            for (const char* figure : {"rel_rms", "p99", "max_sampled", "max_bound"}) stage["error"][kind][figure].figure();
    });
    asset["limit"]["metric"].text();
    asset["limit"]["value"].number(0, HUGE_VAL);
    asset["passed"].flag();
    if (asset.has("failures"))
        asset["failures"].each([](const Place& failure) {
            for (const char* key : {"subject", "detail", "message"}) failure[key].text();
        });
    if (!asset.has("light")) return;
    const Place light = asset["light"];
    light.object();
    for (const char* key : {"diffuse_rms", "specular_rms", "ratio_rms", "ratio_rel_rms", "texels"})
        if (light.has(key)) light[key].figure();
    for (const char* key : {"moments", "kernel_moments", "error_moments"})
        if (light.has(key)) light[key].each([](const Place& moment) { moment.number(-HUGE_VAL, HUGE_VAL); });
    if (light.has("bake")) light["bake"].text();
}

/// The whole shading of a scene, or of one of its light maps.
void checkShading(const Place& shading) {
    for (const char* key : {"rel_rms", "rel_rms_bound", "light_rms"}) shading[key].figure();
    shading["lights"].eachMember([](const Place& light) { light.figure(); });
    shading["parts"].each([](const Place& part) {
        for (const char* key : {"asset", "shading"}) part[key].text();
        checkKind(part["kind"]);
        for (const char* key : {"share", "rel_rms", "light_rms"}) part[key].figure();
        part["stages"].each([](const Place& stage) {
            stage["name"].text();
            stage["share"].figure();
        });
    });
}

void checkWhole(const Place& whole) {
    checkShading(whole);
    if (whole.has("light_maps"))
        whole["light_maps"].each([](const Place& map) {
            map["name"].text();
            map["weight"].figure();
            checkShading(map);
        });
    whole["apart"].each([](const Place& asset) {
        asset["asset"].text();
        checkKind(asset["kind"]);
        asset["rel_rms"].figure();
    });
}

template <class Check>
Result<void> checked(const Json& json, const std::string& subject, Check check) {
    try {
        check(Place(json, subject));
        return {};
    } catch (const Mistake& mistake) {
        return tl::make_unexpected(mistake.error);
    }
}

}  // namespace

Json parseJson(const std::string& text) {
    bool isTooDeep = false;
    Json json = Json::parse(
        text,
        [&](int depth, Json::parse_event_t, Json&) {
            isTooDeep = isTooDeep || depth > kDeepest;
            return !isTooDeep;
        },
        false);
    return isTooDeep ? Json(Json::value_t::discarded) : json;
}

std::string textOf(const Json& json) {
    return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

Result<void> checkManifest(const Json& manifest, const std::string& subject) {
    return checked(manifest, subject, [](const Place& root) {
        root["schema"].integer(1, 1);
        for (const char* key : {"scene", "scene_directory", "target"}) root[key].text();
        root["tool"].object();
        root["shader"]["file"].file();
        root["shader"]["digest"].text();
        root["assets"].each(checkManifestAsset);
    });
}

Result<void> checkReport(const Json& report, const std::string& subject) {
    return checked(report, subject, [](const Place& root) {
        root["scene"].text();
        root["passed"].flag();
        for (const char* key : {"seconds", "peak_rss_bytes"}) root[key].number(0, HUGE_VAL);
        root["assets"].each(checkReportAsset);
        root["skipped"].list(0);
        if (root.has("files")) root["files"].each(checkReportFile);
        if (root.has("whole")) checkWhole(root["whole"]);
        const Place budget = root["budget"];
        budget["limit_bytes"].bytesOrNull();
        budget["used_bytes"].bytes();
        for (const char* key : {"by_kind", "by_format"}) budget[key].object();
    });
}

}  // namespace lightcook::pipeline
