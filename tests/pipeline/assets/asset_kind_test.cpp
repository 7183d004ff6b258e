#include "pipeline/assets/asset_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/light_map_layout.h"

namespace lightcook::pipeline {
namespace {

TEST(AssetKind, NamesAreThoseOfManifestAndReport) {
    EXPECT_THAT(enumNames<AssetKind>(), testing::ElementsAre("light-map", "dominant", "cubemap", "lut", "rsrm", "mesh"));
    for (const AssetKindInfo& row : allAssetKinds()) {
        EXPECT_EQ(assetKindFromName(row.name), row.id);
        EXPECT_FALSE(row.caption.empty()) << row.name;
    }
    EXPECT_FALSE(assetKindFromName("light map").has_value());
}

TEST(AssetKind, ALightMapMayHaveTheFilesOfAnyLayout) {
    const std::vector<std::string> endings = info(AssetKind::LightMap).fileEndings();
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts())
        for (const formats::LightMapTextureInfo& texture : layout.textures)
            EXPECT_THAT(endings, testing::Contains("_" + std::string(texture.name)));
}

}  // namespace
}  // namespace lightcook::pipeline
