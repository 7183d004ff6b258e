#include "pipeline/command/decode.h"

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/session.h"
#include "pipeline/command/texture_file.h"

namespace lightcook::pipeline {

formats::Result<void> decodeTexture(const DecodeCommand& command) {
    if (auto checked = requireTextureFile(command.input); !checked) return checked;
    const auto image = readAnyImage(command.input, command.mip, command.layer);
    if (!image) return tl::make_unexpected(image.error());
    return formats::writeExr(command.output, image->texels.view(), image->channelCount == 4 ? 4 : 3);
}

CommandFunction defineDecode(CLI::App& app) {
    const auto options = std::make_shared<DecodeCommand>();
    addFileOption(app, "input", options->input, "A .ktx2 or .dds file")->required();
    addFileOption(app, "output", options->output, "The EXR to write")->required();
    app.add_option("--mip", options->mip, "Level of the texture")->check(CLI::NonNegativeNumber)->type_name("N")->capture_default_str();
    app.add_option("--layer", options->layer, "Layer of an array")->check(CLI::NonNegativeNumber)->type_name("N")->capture_default_str();
    app.footer("A cubemap is written as a vertical strip of its six faces.");
    return [options](Session& session) { return session.finish(decodeTexture(*options)); };
}

}  // namespace lightcook::pipeline
