#include "pipeline/command/decode.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "formats/gpu_texture.h"
#include "formats/plain_image.h"
#include "pipeline/assets/textures.h"
#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/texture_file.h"

namespace lightcook::pipeline {

namespace {

/// Returns what a cooked texture says of itself (textureMetadata); an empty object for any other.
formats::Result<Json> storedMetadata(const std::filesystem::path& file) {
    LC_TRY(texture, formats::TextureReader::open(file));
    const auto found = texture->metadata().find(kMetadataKey);
    Json metadata = found == texture->metadata().end() ? Json() : Json::parse(found->second, nullptr, false);
    return metadata.is_object() ? metadata : Json::object();
}

/// Returns a list of constants: "range = 8, bias = [0, 0.1]".
std::string constantsText(const Json& constants) {
    std::string list;
    for (const auto& [name, value] : constants.items()) list += fmt::format("{}{} = {}", list.empty() ? "" : ", ", name, value.dump());
    return list;
}

}  // namespace

formats::Result<Json> decodeTexture(const DecodeCommand& command) {
    LC_CHECK(requireTextureFile(command.input));
    LC_CHECK(requireExrFile(command.output));
    LC_TRY(image, readAnyImage(command.input, command.mip, command.layer));
    const int channels = image->hasAlpha ? 4 : 3;
    LC_TRY(folders, FoldersOfFile::make(command.output));
    LC_CHECK(formats::writeExr(command.output, image->texels.view(), channels));
    Json facts = {{"width", image->texels.width()},
                  {"height", image->texels.height()},
                  {"channels", channels},
                  {"mip", command.mip},
                  {"layer", command.layer}};
    LC_TRY(metadata, storedMetadata(command.input));
    if (const Json constants = metadata->value("constants", Json::object()); !constants.empty()) facts["constants"] = constants;
    return facts;
}

namespace {

/// Says that the texels of a cooked texture are no light yet.
void noteConstants(Session& session, const DecodeCommand& command, const Json& facts) {
    if (!facts.contains("constants")) return;
    session.terminal.note(command.input.string(),
                          fmt::format("the texels are written as they are stored. The shader makes light of them with {}; `lightcook "
                                      "reconstruct` writes the light of a cooked light map",
                                      constantsText(facts["constants"])));
}

}  // namespace

CommandFunction defineDecode(CLI::App& app) {
    struct Options : DecodeCommand {
        JsonOutput json;
    };
    const auto options = std::make_shared<Options>();
    addFileOption(app, "input", options->input, "A .ktx2 or .dds file")->required();
    declareWritten(addFileOption(app, "output", options->output, "The EXR to write"), Written::File)->required();
    app.add_option("--mip", options->mip, "Level of the texture")->check(CLI::NonNegativeNumber)->capture_default_str();
    app.add_option("--layer", options->layer, "Layer of an array")->check(CLI::NonNegativeNumber)->capture_default_str();
    options->json.add(app, "what was written");
    app.footer(R"(Texels are written as they are stored. Of a cooked texture the shader makes light of them with the constants of
its metadata, such as "range", which the command names: `lightcook reconstruct` writes the light of a
cooked light map. A cubemap is written as a vertical strip of its six faces. The values are float, so only EXR
can hold them.)");
    return [options](Session& session) {
        options->json.prepare(session);
        const formats::Result<Json> facts = decodeTexture(*options);
        if (facts) noteConstants(session, *options, *facts);
        return options->json.finish(session, facts);
    };
}

}  // namespace lightcook::pipeline
