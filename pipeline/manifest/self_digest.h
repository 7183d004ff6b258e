// Documents that carry their own digest: whichever of their bytes is changed, it shows.
#pragma once

#include <string>

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// The document as text with a last member "digest": that of this very text, the digest's own digits taken as zeros. One that it has is
/// replaced.
std::string sealed(Json document);
/// Refuses a text that is not what sealed() made of some document: Verification, of `subject`.
formats::Result<void> checkSeal(const std::string& text, const std::string& subject);

}  // namespace lightcook::pipeline
