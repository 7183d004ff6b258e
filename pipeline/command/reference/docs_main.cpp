// lightcook_docs: writes the files that are derived from the program's tables.
//   lightcook_docs FOLDER          the generated pages of docs/reference
//   lightcook_docs --shell FOLDER  lightcook.1, completions/lightcook.bash, completions/_lightcook, completions/lightcook.fish
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/command/reference/completions.h"
#include "pipeline/command/reference/reference.h"

namespace {

using namespace lightcook::pipeline;

using Files = std::vector<std::pair<std::string, std::string>>;

Files pages() {
    Files files;
    for (ReferencePage& page : referencePages()) files.emplace_back(std::move(page.name), std::move(page.text));
    return files;
}

Files shellFiles() {
    const ProgramDoc program = describeProgram();
    return {{"lightcook.1", manPage(program)},
            {"completions/lightcook.bash", bashCompletion(program)},
            {"completions/_lightcook", zshCompletion(program)},
            {"completions/lightcook.fish", fishCompletion(program)}};
}

bool write(const std::filesystem::path& folder, const Files& files) {
    for (const auto& [name, text] : files) {
        const std::filesystem::path file = folder / name;
        std::error_code code;
        std::filesystem::create_directories(file.parent_path(), code);
        std::ofstream stream(file, std::ios::binary);
        stream << text;
        if (!stream.flush()) {
            std::fprintf(stderr, "lightcook_docs: cannot write %s\n", file.c_str());
            return false;
        }
    }
    return true;
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    if (arguments.size() == 1 && !arguments[0].starts_with("-")) return write(arguments[0], pages()) ? 0 : 1;
    if (arguments.size() == 2 && arguments[0] == "--shell") return write(arguments[1], shellFiles()) ? 0 : 1;
    std::fprintf(stderr, "usage: lightcook_docs FOLDER | lightcook_docs --shell FOLDER\n");
    return 2;
}
