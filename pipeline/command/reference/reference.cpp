#include "pipeline/command/reference/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <vector>

#include "formats/light_map_layout.h"
#include "pipeline/command/reference/field_tables.h"
#include "pipeline/command/reference/schemas.h"
#include "pipeline/command/terminal/terminal.h"
#include "pipeline/cook/preview.h"
#include "pipeline/document/json_schema.h"
#include "pipeline/estimate/estimate.h"
#include "pipeline/graph/user_settings.h"
#include "pipeline/graph/version.h"
#include "pipeline/manifest/folder_difference.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/budgets.h"
#include "pipeline/report/collection.h"
#include "pipeline/report/exit_codes.h"
#include "pipeline/report/report.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {
namespace {

constexpr std::size_t kMarkdownColumns = 100;
constexpr const char* kGenerated = "<!-- Generated from the program's own tables: ./dev docs -->\n\n";

/// Returns the words of a text in lines of at most `columns` characters.
std::string wrapped(const std::string& text, std::size_t columns) {
    std::istringstream words(text);
    std::string lines, line, word;
    while (words >> word) {
        if (!line.empty() && line.size() + 1 + word.size() > columns) {
            lines += line + "\n";
            line.clear();
        }
        line += (line.empty() ? "" : " ") + word;
    }
    return lines + line + "\n";
}

/// Returns the parts of a text between empty lines. Code between fences (```) is one part, with the empty lines in it.
std::vector<std::string> textPartsOf(const std::string& text) {
    std::vector<std::string> parts;
    for (std::size_t start = 0; start < text.size();) {
        const std::size_t close = text.compare(start, 3, "```") == 0 ? text.find("\n```", start) : start;
        const std::size_t end = std::min(text.find("\n\n", close), text.size());
        if (end > start) parts.push_back(text.substr(start, end - start));
        start = end + 2;
    }
    return parts;
}

/// Returns the lines of a part of notes that is code, without the two spaces that begin each of them; nothing for a paragraph.
std::vector<std::string> codeLinesOf(const std::string& part) {
    std::vector<std::string> code;
    std::istringstream lines(part);
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with("  ")) return {};
        code.push_back(line.substr(2));
    }
    return code;
}

/// Returns a part of notes as Markdown: code in a block, with its lines; a paragraph wrapped.
std::string markdownOf(const std::string& part) {
    const std::vector<std::string> code = codeLinesOf(part);
    return code.empty() ? wrapped(part, kMarkdownColumns) : fmt::format("```\n{}\n```\n", fmt::join(code, "\n"));
}

std::string joinedNames(const OptionDoc& option) {
    return fmt::format("{}", fmt::join(option.names, ", "));
}

/// Returns the description with its first letter in lower case, as cells of tables have it.
std::string cellOf(const OptionDoc& option) {
    std::string text = option.description;
    if (text.size() > 1 && std::isupper(static_cast<unsigned char>(text[0])) != 0 && std::islower(static_cast<unsigned char>(text[1])) != 0)
        text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
    return text;
}

std::string escapedForCell(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '|') escaped += '\\';
        escaped += c == '<' ? std::string("&lt;") : std::string(1, c);
    }
    return escaped;
}

std::string optionTable(const std::vector<OptionDoc>& options) {
    std::string text = "| option | value | default | meaning |\n| --- | --- | --- | --- |\n";
    for (const OptionDoc& option : options) {
        const std::string value = option.placeholder.empty() ? "" : fmt::format("`{}`", escapedForCell(option.placeholder));
        const std::string fallback = option.isRequired ? "required" : option.fallback.empty() ? "" : fmt::format("`{}`", option.fallback);
        text += fmt::format("| `{}` | {} | {} | {} |\n", joinedNames(option), value, fallback, escapedForCell(cellOf(option)));
    }
    return text;
}

std::string headingOf(const KeyTable& table) {
    if (table.name.empty()) return "Top of the file";
    return table.isArray ? fmt::format("`[[{}]]`", table.name) : fmt::format("`[{}]`", table.name);
}

/// Returns the tables of keys of a TOML document, each under a heading.
std::string keyTables(std::span<const KeyTable> tables) {
    std::string text;
    for (const KeyTable& table : tables) {
        text += fmt::format("\n## {}\n\n", headingOf(table));
        if (!table.intro.empty()) text += table.intro + "\n\n";
        text += "| key | type | default | meaning |\n| --- | --- | --- | --- |\n";
        for (const KeyRow& key : table.keys)
            text += fmt::format("| `{}` | {} | {} | {} |\n", key.name, key.type, key.fallback, key.caption);
        if (!table.outro.empty()) text += "\n" + table.outro + "\n";
    }
    return text;
}

/// Escapes what troff would read as a command, and sets hyphens as minus signs, so that options can be copied.
std::string troff(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '\\')
            escaped += "\\e";
        else if (c == '-')
            escaped += "\\-";
        else if (c == '|')
            escaped += "|\\:";  // lines may break after it
        else
            escaped += c;
    }
    return escaped.starts_with('.') || escaped.starts_with('\'') ? "\\&" + escaped : escaped;
}

std::string troffOption(const OptionDoc& option) {
    std::string names;
    for (const std::string& name : option.names) names += fmt::format("{}\\fB{}\\fR", names.empty() ? "" : ", ", troff(name));
    if (!option.placeholder.empty() && !option.isPositional) names += fmt::format(" \\fI{}\\fR", troff(option.placeholder));
    const std::string fallback = option.fallback.empty() ? "" : fmt::format(" (default: {})", option.fallback);
    return fmt::format(".TP\n{}\n{}\n", names, troff(option.description + fallback + "."));
}

/// Returns notes in troff: paragraphs filled; code indented, with its lines.
std::string troffParagraphs(const std::string& notes) {
    std::string text;
    for (const std::string& part : textPartsOf(notes)) {
        const std::vector<std::string> code = codeLinesOf(part);
        text += code.empty() ? ".PP\n" : ".PP\n.RS 4\n.nf\n";
        std::istringstream lines(code.empty() ? wrapped(part, 78) : fmt::format("{}", fmt::join(code, "\n")));
        for (std::string line; std::getline(lines, line);) text += troff(line) + "\n";
        if (!code.empty()) text += ".fi\n.RE\n";
    }
    return text;
}

/// Returns true for a part of a page whose lines stay as they are: a heading, a table, code between fences.
bool keepsItsLines(const std::string& part) {
    return part.starts_with("#") || part.starts_with("|") || part.starts_with("```");
}

/// Returns a page with its paragraphs wrapped, and the note that it is generated below its title.
std::string generatedPage(const std::string& page) {
    std::string text;
    for (const std::string& part : textPartsOf(page)) {
        const bool isTitle = text.empty();
        text += keepsItsLines(part) ? part : wrapped(part, kMarkdownColumns);
        while (text.ends_with("\n")) text.pop_back();
        text += "\n\n";
        if (isTitle) text += kGenerated;
    }
    if (text.ends_with("\n\n")) text.pop_back();
    return text;
}

/// Returns the page of a JSON document.
std::string documentReference(const char* title, const std::string& intro, const Json& schema) {
    const bool hasStructs = schema.contains("$defs");
    return generatedPage(fmt::format(
        "# {}\n\n{}{}\n\n{}", title, intro,
        hasStructs ? " A type that is a link has a table of its own below; `.` stands before a member of an object without one." : "",
        fieldTables(schema)));
}

}  // namespace

std::vector<ReferencePage> referencePages() {
    const Json manifest = manifestSchema(), report = reportSchema(), estimate = documentSchema<Estimate>("lightcook: what estimate writes");
    return {
        {"commands.md", commandReference(describeProgram())},
        {"scene-file.md", sceneFileReference()},
        {"light-map-layouts.md", layoutReference()},
        {"manifest.md",
         documentReference("Manifest", "`cooked.json` tells an engine everything that it needs to load and decode a cooked scene.",
                           manifest)},
        {"report.md", documentReference("Report",
                                        "`report.json` adds up a cook or a verification: bytes against the budget, error against the "
                                        "limit, time. Figures that are not finite are `null`.",
                                        report)},
        {"collection.md",
         documentReference(
             "Report of several scenes",
             "`lightcook report DIR DIR... --json F` writes one report of several cooked folders. Figures that are not finite are `null`.",
             documentSchema<CollectionReport>(""))},
        {"history.md",
         documentReference(
             "History",
             "`lightcook report DIR... --history F` and `lightcook cook --history F` append a line of JSON for each scene, and "
             "the page of a report draws the trend. A line that equals the last one of its scene and target is not written again.",
             documentSchema<HistoryLine>(""))},
        {"estimate.md",
         documentReference("Estimate", "`lightcook estimate MESH... --texel-density D --json F` writes what the light maps of meshes cost.",
                           estimate)},
        {"difference.md",
         documentReference("Difference of cooked folders", "`lightcook diff OLD NEW --json F` writes what a patch has to carry.",
                           documentSchema<FolderDifference>(""))},
        {"preview.md",
         documentReference("Preview", "`lightcook cook SCENE --preview --json F` writes what a preview has found, in place of a report.",
                           documentSchema<PreviewSummary>(""))},
        {"budgets.md", budgetsReference()},
        {"configuration-file.md", configurationReference()},
        {"cooked.schema.json", schemaText(manifest)},
        {"report.schema.json", schemaText(report)},
        {"estimate.schema.json", schemaText(estimate)}};
}

std::string commandReference(const ProgramDoc& program) {
    std::string text = "# Commands\n\n";
    text += kGenerated;
    text += wrapped(
        "`lightcook help COMMAND` and `lightcook COMMAND --help` print the same as this page. A terminal gets one line of progress: "
        "actions that are done, stages that run, time left. On a pipe, commands that cook print a line on standard error when an asset is "
        "done, and one line at the end (verdict, sizes, what came from the cache); `verify` and `report` print a table, `compare` and "
        "`info` what they found. `--quiet` leaves all of it out "
        "except "
        "errors, warnings and the output of `compare` and `info`. "
        "`lightmap`, `dominant`, `cubemap`, `lut` and `rsrm` convert one asset and verify it like a scene: `--max-error` is the limit of "
        "that asset.",
        kMarkdownColumns);
    text += "\n" +
            wrapped(
                "A fraction is a number or a percentage: `0.02` or `2%`. Every command has `--json F`; `-` is standard output, and "
                "what is meant for people then goes to standard error. The JSON of a command that failed has `passed` "
                "(false), `exit_code` and `errors`, a list of `code`, `subject` and `detail`, and of the `asset`, `file` and `line` that "
                "an error is about, where it has them. A mistake on the command line is reported in the order typed, with the nearest "
                "known name, and in the file of `--json` too.",
                kMarkdownColumns);
    text += "\n| command | does |\n| --- | --- |\n";
    for (const CommandDoc& command : program.commands)
        text += fmt::format("| [`{}`](#{}) | {} |\n", command.name, command.name, command.summary);
    text += "\n## Options of all commands\n\n" + optionTable(program.options);
    text += "\n## Exit codes\n\n| code | meaning |\n| --- | --- |\n";
    for (const ExitCodeInfo& row : allExitCodes()) text += fmt::format("| {} | {} |\n", row.code, row.meaning);
    for (const CommandDoc& command : program.commands) {
        text += fmt::format("\n## {}\n\n`lightcook {}`\n\n{}.\n\n{}", command.name, command.usage(), command.summary,
                            optionTable(command.options));
        for (const std::string& part : textPartsOf(command.notes)) text += "\n" + markdownOf(part);
    }
    return text;
}

std::string sceneFileReference() {
    return generatedPage(
        "# The scene file\n\n"
        "A scene is one TOML file. Paths are relative to it. [examples/cornell/scene.toml](../../examples/cornell/scene.toml) is a "
        "complete example with comments, and [from a baker to a scene](../guide/from-a-baker-to-a-scene.md) explains the choices. Unknown "
        "keys are refused, with the nearest known key. Every mistake is one line with file, line and column, actual and expected value, "
        "and exit code 2. Each key of `[output]` is an option of `cook`, such as "
        "`--max-error` for `max_error` (`--layout` for `light_map_layout`, and `--no-draco`), which goes before the file and before what "
        "its "
        "light maps, probes, gradients and tables have of their own.\n" +
        keyTables(sceneKeyTables()));
}

std::string budgetsReference() {
    return generatedPage(
        "# Budgets\n\n`budgets.toml` has the GPU memory that each platform allows; `lightcook report --budgets FILE` holds cooked "
        "scenes against it and ends with code 5 if a limit is passed. Sizes are strings: `\"4096\"`, `\"512 KiB\"`, `\"2 MiB\"`. "
        "Unknown keys are refused with the nearest known one.\n" +
        keyTables(budgetKeyTables()) +
        "\n## Example\n\n```toml\nschema = 1\n\n[[platform]]\nname = \"console\"\ntarget = \"bc\"\ntotal = \"512 MiB\"\nscene = \"8 "
        "MiB\"\nscenes = { lobby = \"12 MiB\" }\nkinds = { light-map = \"6 MiB\" }\n```\n");
}

std::string configurationReference() {
    const KeyTable& table = cacheKeyTable();
    std::string sources = "| key | option | variable |\n| --- | --- | --- |\n";
    for (const KeyRow& key : table.keys) sources += fmt::format("| `{}` | `{}` | `{}` |\n", key.name, optionOf(key), variableOf(key));
    return generatedPage(
        "# The configuration file\n\n"
        "`$XDG_CONFIG_HOME/lightcook/config.toml`, else `~/.config/lightcook/config.toml`, has what a user wants in every cook. It need "
        "not exist. An option of the command line goes before a variable of the environment, and that before the file. Paths are "
        "relative to the file. Unknown keys and other types are refused with file, line and column, and exit code 2. "
        "[A cache for a team](../guide/team-cache.md) has an example.\n\n"
        "What the file says of its remote cache, `remote_upload` and `remote_credentials`, is for the address `remote_cache` of the file "
        "alone. With another address, from an option or a variable, it has no effect.\n" +
        keyTables(std::span(&table, 1)) + "\n## Options and variables\n\n" + sources);
}

std::string layoutReference() {
    std::string text = "# Light-map layouts\n\n" + std::string(kGenerated);
    text += wrapped(
        "What each layout costs: GPU memory of a texel, and the decode of one sample. [Layouts](../theory/layouts.md) has the decodes as "
        "formulas. A fetch is a read of one array layer, filtered or of one texel. Operations are scalar multiply-adds of the decode of "
        "all coefficients; shading comes on top. Of two figures the first is under filter `hardware`, the second under `decoded`. Tables "
        "are the learned constants of one cluster of charts, a row of texture `tables`; a sample reads "
        "those of its own cluster. `max_fetches`, `max_decode_ops` and `cost` of the [scene file](scene-file.md#output) use these figures.",
        kMarkdownColumns);
    text += "\n| layout | holds | textures (layers) |";
    for (const formats::TargetInfo& target : formats::allTargets()) text += fmt::format(" `{}` [bits] |", target.name);
    text += " fetches | operations | tables [bytes a cluster] | cannot show |\n| --- | --- | --- |";
    for (std::size_t i = 0; i < formats::allTargets().size(); ++i) text += " ---: |";
    text += " ---: | ---: | ---: | --- |\n";
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts()) {
        std::vector<std::string> textures;
        for (const formats::LightMapTextureInfo& texture : layout.textures)
            textures.push_back(fmt::format("`{}` ({})", texture.name, texture.layerCount));
        text += fmt::format("| `{}` | {} | {} |", layout.name, layout.caption, fmt::join(textures, ", "));
        for (const formats::TargetInfo& target : formats::allTargets()) text += fmt::format(" {} |", formats::textureBits(layout, target));
        std::vector<int> fetches, operations;
        for (const formats::LightMapFilterInfo& filter : formats::kLightMapFilters) {
            if (!layout.mayHave(filter.id)) continue;
            fetches.push_back(layout.fetchCount(filter.id));
            operations.push_back(layout.operations(filter.id));
        }
        text += fmt::format(" {} | {} | {} | {} |\n", fmt::join(fetches, " / "), fmt::join(operations, " / "), layout.clusterTableBytes(),
                            layout.lacks);
    }
    return text;
}

std::string manPage(const ProgramDoc& program) {
    std::string text = fmt::format(".TH LIGHTCOOK 1 \"\" \"{} {}\" \"User Commands\"\n.ad l\n", kToolName, kToolVersion);
    text += ".SH NAME\nlightcook \\- compress baked lighting into GPU textures with certified error\n";
    text += ".SH SYNOPSIS\n\\fBlightcook\\fR [\\fIoptions\\fR] \\fIcommand\\fR [\\fIarguments\\fR]\n";
    text += ".SH DESCRIPTION\n" + troff(program.summary) + "\n.SH OPTIONS\nThese stand before or after any command.\n";
    for (const OptionDoc& option : program.options) text += troffOption(option);
    text += ".SH COMMANDS\n";
    for (const CommandDoc& command : program.commands) {
        text += fmt::format(".SS lightcook {}\n{}.\n", troff(command.usage()), troff(command.summary));
        for (const OptionDoc& option : command.options) text += troffOption(option);
        text += troffParagraphs(command.notes);
    }
    text += ".SH EXIT STATUS\n";
    for (const ExitCodeInfo& row : allExitCodes()) text += fmt::format(".TP\n\\fB{}\\fR\n{}\n", row.code, troff(std::string(row.meaning)));
    text += ".SH ENVIRONMENT\n";
    for (const KeyRow& key : cacheKeyTable().keys)
        text += fmt::format(".TP\n\\fB{}\\fR\nGoes before the key {} of the configuration file: {}.\n", variableOf(key), troff(key.name),
                            troff(key.caption));
    text +=
        ".TP\n\\fBNO_COLOR\\fR\nIf it is set and not empty, nothing is coloured.\n.SH FILES\n.TP\n"
        "\\fI$XDG_CONFIG_HOME/lightcook/config.toml\\fR, else \\fI~/.config/lightcook/config.toml\\fR\nTable [cache] with the keys above.\n"
        ".TP\n\\fI$XDG_CACHE_HOME/lightcook\\fR, else \\fI~/.cache/lightcook\\fR\nThe user's cache folder.\n";
    return text;
}

}  // namespace lightcook::pipeline
