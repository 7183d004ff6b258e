// SHA-256, by which the shared cache names contents.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "formats/error.h"

struct evp_md_ctx_st;

namespace lightcook::pipeline {

/// A digest in the making.
class Sha256 {
public:
    Sha256();
    void add(std::string_view bytes);
    /// Returns 64 hexadecimal digits. Nothing may be added afterwards.
    std::string hex();

private:
    std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> state_;
};

std::string sha256OfText(std::string_view text);
formats::Result<std::string> sha256OfFile(const std::filesystem::path& file);

}  // namespace lightcook::pipeline
