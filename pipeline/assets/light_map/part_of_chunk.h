// Results of actions by chunk of a light map, in the cache. An action reads the chunks of a bake that changed since an earlier cook.
#pragma once

#include <string>
#include <type_traits>

#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/strip_digest.h"
#include "pipeline/graph/part_cache.h"

namespace lightcook::pipeline {

/// Returns the result of chunk `index` from the cache or, where the cache does not have it, from make(chunk), which returns a Result.
/// what  digest of all else that it depends on
template <class Make>
auto partOfChunk(LightMapSource& source, int index, const ActionContext& context, const std::string& what, Make make) {
    using Made = std::invoke_result_t<Make, const formats::LightMapStrip&>;
    return cachedPart(
        context.parts,
        [&]() -> formats::Result<std::string> {
            LC_TRY(chunk, source.digestOfChunk(index, *context.parts));
            return digestOf(what, *chunk);
        },
        [&]() -> Made {
            LC_TRY(chunk, source.chunk(index));
            return make(**chunk);
        });
}

}  // namespace lightcook::pipeline
