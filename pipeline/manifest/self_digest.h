// Documents that have their own digest as a last member, so that a change of any byte shows.
#pragma once

#include <string>

#include "formats/error.h"
#include "pipeline/document/json.h"

namespace lightcook::pipeline {

/// Returns the document as text with a last member "digest": the XXH3-128 of this very text, with zeros for the digest's own digits. A
/// digest that the document has is replaced.
std::string withSelfDigest(Json document);

/// Refuses a text that withSelfDigest() did not make, with code Verification.
formats::Result<void> checkSelfDigest(const std::string& text, const formats::Subject& subject);

}  // namespace lightcook::pipeline
