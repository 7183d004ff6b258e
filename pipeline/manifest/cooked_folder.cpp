#include "pipeline/manifest/cooked_folder.h"

#include <algorithm>

#include "formats/target.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {

std::string expectedCookedFolder(const std::filesystem::path& folder) {
    std::error_code code;
    std::vector<std::filesystem::path> cooked;
    for (std::filesystem::directory_iterator each(folder, code), end; !code && each != end; each.increment(code))
        if (std::error_code ignored; std::filesystem::is_regular_file(each->path() / kManifestName, ignored))
            cooked.push_back(each->path());
    const auto first = std::ranges::min_element(cooked);
    return std::string("the output folder of `lightcook cook`") + (first == cooked.end() ? "" : ", such as " + first->string());
}

std::vector<std::filesystem::path> targetFolders(const std::filesystem::path& folder) {
    const auto isCooked = [](const std::filesystem::path& each) {
        std::error_code code;
        return std::filesystem::is_regular_file(each / kManifestName, code);
    };
    std::vector<std::filesystem::path> folders;
    if (!isCooked(folder))
        for (const formats::TargetInfo& target : formats::allTargets())
            if (isCooked(folder / target.name)) folders.push_back(folder / target.name);
    return folders.empty() ? std::vector{folder} : folders;
}

}  // namespace lightcook::pipeline
