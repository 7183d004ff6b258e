#include "pipeline/command/decode.h"

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "formats/plain_image.h"
#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/texture_file.h"

namespace lightcook::pipeline {

formats::Result<Json> decodeTexture(const DecodeCommand& command) {
    LC_CHECK(requireTextureFile(command.input));
    LC_CHECK(requireExrFile(command.output));
    LC_TRY(image, readAnyImage(command.input, command.mip, command.layer));
    const int channels = image->hasAlpha ? 4 : 3;
    LC_TRY(folders, FoldersOfFile::make(command.output));
    LC_CHECK(formats::writeExr(command.output, image->texels.view(), channels));
    return Json{{"width", image->texels.width()},
                {"height", image->texels.height()},
                {"channels", channels},
                {"mip", command.mip},
                {"layer", command.layer}};
}

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
    app.footer("A cubemap is written as a vertical strip of its six faces. The values are float, so only EXR can hold them.");
    return [options](Session& session) {
        options->json.prepare(session);
        return options->json.finish(session, decodeTexture(*options));
    };
}

}  // namespace lightcook::pipeline
