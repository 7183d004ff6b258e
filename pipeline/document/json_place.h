// A value inside a JSON document, with its path: reading it checks it, and an error names the place, as "cooked.json,
// assets/1/textures/0/file: found 3, expected a string".
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "formats/error.h"
#include "pipeline/document/json.h"

namespace lightcook::pipeline {

/// Thrown by JsonPlace at the first value of a wrong shape. checkedJson() turns it into an error value, so that it never leaves a reader.
struct JsonMistake {
    formats::Error error;
};

class JsonPlace {
public:
    /// value    outlives the place
    /// subject  the document, for messages
    /// path     of the value in the document, with slashes; empty at the root
    JsonPlace(const Json& value, std::string subject, std::string path = "")
        : value_(&value), subject_(std::move(subject)), path_(std::move(path)) {}

    /// Throws "found <the value>, expected <expected>".
    [[noreturn]] void fail(const std::string& expected) const;

    const Json& value() const { return *value_; }
    bool has(std::string_view key) const { return value_->is_object() && value_->contains(key); }
    /// Returns the place of a member; fails without one.
    JsonPlace operator[](std::string_view key) const;
    JsonPlace element(std::size_t index) const;
    /// Returns the number of elements of a list; fails if it has fewer than `least`.
    std::size_t count(std::size_t least = 0) const;
    template <class Visit>
    void eachMember(Visit visit) const {
        object();
        for (const auto& [key, member] : value_->items()) visit(key, JsonPlace(member, subject_, path_.empty() ? key : path_ + "/" + key));
    }

    /// Fails unless the value is an object.
    void object() const;
    /// Return the value. Each fails for another type, and for a number out of range.
    bool flag() const;
    const std::string& text() const;
    double number(double low, double high) const;
    std::int64_t integer(std::int64_t low, std::int64_t high) const;
    /// Reads a figure that JSON writes as null where it is not finite: then infinity.
    double numberOrNull(double low, double high) const;
    /// Reads one of some names, and returns its index.
    std::size_t oneOf(std::span<const std::string> names) const;
    /// Reads a path that stays inside the cooked folder.
    const std::string& fileInFolder() const;

private:
    const Json* value_;
    std::string subject_, path_;
};

/// Calls read(JsonPlace of the root) and returns its result, or the error of the first value of a wrong shape.
template <class Read>
auto checkedJson(const Json& json, const formats::Subject& subject, Read read) -> formats::Result<decltype(read(JsonPlace(json, "")))> {
    const JsonPlace root(json, subject.text);
    try {
        if constexpr (std::is_void_v<decltype(read(root))>) {
            read(root);
            return {};
        } else {
            return read(root);
        }
    } catch (const JsonMistake& mistake) {
        formats::Error error = mistake.error;
        error.file = subject.file;
        return tl::make_unexpected(std::move(error));
    }
}

}  // namespace lightcook::pipeline
