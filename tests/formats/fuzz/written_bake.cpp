#include "tests/formats/fuzz/written_bake.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <vector>

#include "tests/formats/exr_fixture.h"
#include "tests/formats/lmbake_fixture.h"
#include "tests/formats/picture_fixture.h"
#include "tests/formats/surface_fixture.h"
#include "tests/fuzz/target.h"

namespace lightcook::formats {
namespace {

constexpr int kMostSide = 16;
constexpr std::size_t kMostFiles = 32, kMostChannels = 40;

/// The numbers of a bake, a byte each: those of light, and those that no light has.
class Numbers {
public:
    explicit Numbers(std::string bytes) : bytes_(std::move(bytes)) {}
    std::uint8_t byte() { return bytes_.empty() ? 64 : static_cast<std::uint8_t>(bytes_[next_++ % bytes_.size()]); }
    float number() {
        constexpr std::array kOdd = {std::numeric_limits<float>::quiet_NaN(),
                                     std::numeric_limits<float>::infinity(),
                                     -std::numeric_limits<float>::infinity(),
                                     std::numeric_limits<float>::max(),
                                     std::numeric_limits<float>::denorm_min(),
                                     -0.0f,
                                     1e30f,
                                     65504.0f,
                                     1e-30f,
                                     -1.0f,
                                     0.5f,
                                     -1e5f};
        const std::size_t value = byte();
        return value < kOdd.size() ? kOdd.at(value) : (static_cast<float>(value) - 64) / 64;
    }

private:
    std::string bytes_;
    std::size_t next_ = 0;
};

const std::filesystem::path& square() {
    static const std::filesystem::path file = [] {
        std::filesystem::path mesh = fuzz::inputFolder() / "square.glb";
        writeSquare(mesh, {.name = "Square"});
        return mesh;
    }();
    return file;
}

std::filesystem::path folderOfBakes() {
    return fuzz::inputFolder() / "bake";
}

/// Returns a name in the folder of bakes; empty for one that leads elsewhere.
std::filesystem::path placeOf(std::istream& words) {
    std::string name;
    words >> name;
    const bool isPlain =
        !name.empty() && name.size() < 100 && name != "." && name != ".." && name.find_first_of(std::string("/\0", 2)) == std::string::npos;
    return isPlain ? folderOfBakes() / name : std::filesystem::path();
}

void writePicture(const std::filesystem::path& file, std::istream& words, Numbers& numbers) {
    int width = 0, height = 0;
    char by = 0;
    words >> width >> by >> height;
    width = std::clamp(width, 1, kMostSide);
    height = std::clamp(height, 1, kMostSide);
    ExrRecipe recipe;
    recipe.width = width;
    recipe.height = height;
    recipe.isZip = false;
    for (std::string channel; recipe.channels.size() < kMostChannels && words >> channel;) {
        if (channel.find('\0') != std::string::npos) continue;
        Image<float> texels(width, height);
        for (float& texel : texels.texels()) texel = numbers.number();
        recipe.channels[channel.substr(0, 30)] = [texels = std::make_shared<Image<float>>(std::move(texels))](int x, int y) {
            return texels->at(x, y);
        };
    }
    if (file.extension() != ".png") {
        if (!recipe.channels.empty()) writeRecipe(file, recipe);
        return;
    }
    writePng(file, width, height, std::clamp(static_cast<int>(recipe.channels.size()), 1, 4),
             [&](int, int, int) { return numbers.byte(); });
}

template <class Enum>
void set(Enum& convention, const std::string& name) {
    convention = conventionFromName<Enum>(name).value_or(convention);
}

/// Sets a member of a description by its key.
void describe(LightMapDescription& description, const std::string& key, std::istream& words) {
    std::string value;
    words >> value;
    if (key == "bake") description.bake = value;
    if (key == "phase") set(description.phase, value);
    if (key == "frame") set(description.frame, value);
    if (key == "quantity") set(description.quantity, value);
    if (key == "light_units") set(description.lightUnits, value);
    if (key == "encoding") set(description.encoding, value);
    if (key == "coverage") set(description.coverage, value);
    if (key == "axes") description.axes = BakeAxes::fromName(value).value_or(description.axes);
    if (key == "output_axes") description.outputAxes = BakeAxes::fromName(value).value_or(description.outputAxes);
    if (key == "source") description.colors.source = value;
    if (key == "working") description.colors.working = value;
    if (key == "mesh") description.mesh = square();
    if (key == "image") description.image = value;
    if (key == "place") {
        NodePlace place{value};
        words >> place.scale[0] >> place.scale[1] >> place.offset[0] >> place.offset[1];
        const auto isPlace = [](double number) { return std::abs(number) <= kMostPlace; };
        if (std::ranges::all_of(place.scale, isPlace) && std::ranges::all_of(place.offset, isPlace)) description.places.push_back(place);
    }
    if (key == "lmbake") {
        GodotMesh mesh{.path = {"..", value}};
        words >> mesh.x >> mesh.y >> mesh.width >> mesh.height >> mesh.slice;
        description.lmbake = folderOfBakes() / "room.lmbake";
        GodotBake{.meshes = {mesh}}.write(description.lmbake);
    }
    if (key == "part") {
        const std::filesystem::path file = placeOf(words);
        description.parts.push_back(value);
        description.partFiles[value] = file;
    }
    if (key == "flags") {
        const int flags = std::atoi(value.c_str());
        description.repair = (flags & 1) != 0;
        description.takesTangents = (flags & 2) != 0;
        description.isCompressed = (flags & 4) != 0;
        description.hasNoLmbake = (flags & 8) != 0;
    }
}

}  // namespace

WrittenBake writeBake(const std::string& text) {
    std::filesystem::remove_all(folderOfBakes());
    std::filesystem::create_directory(folderOfBakes());
    const std::size_t end = std::min(text.find("\n\n"), text.size());
    Numbers numbers(end + 2 < text.size() ? text.substr(end + 2) : "");
    std::istringstream lines(text.substr(0, end));
    WrittenBake bake;
    std::size_t files = 0;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string key;
        words >> key;
        if (key != "picture" && key != "file") {
            describe(bake.description, key, words);
            continue;
        }
        const std::filesystem::path file = placeOf(words);
        if (file.empty() || ++files > kMostFiles) continue;
        if (bake.file.empty()) bake.file = file;
        if (key == "picture") {
            writePicture(file, words, numbers);
        } else {
            std::string content;
            std::getline(words >> std::ws, content);
            writeContent(file, content);
        }
    }
    if (bake.file.empty()) bake.file = folderOfBakes() / "room.exr";
    return bake;
}

}  // namespace lightcook::formats
