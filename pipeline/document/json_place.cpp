#include "pipeline/document/json_place.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

namespace lightcook::pipeline {
namespace {

/// Returns the value as text, cut where it would make a message long.
std::string shortened(const Json& value) {
    std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

}  // namespace

void JsonPlace::fail(const std::string& expected) const {
    throw JsonMistake{{formats::ErrorCode::FileUnreadable, path_.empty() ? subject_ : subject_ + ", " + path_,
                       fmt::format("found {}, expected {}", shortened(*value_), expected)}};
}

JsonPlace JsonPlace::operator[](std::string_view key) const {
    object();
    const auto found = value_->find(key);
    if (found == value_->end()) fail(fmt::format("an object with a member \"{}\"", key));
    return {*found, subject_, path_.empty() ? std::string(key) : fmt::format("{}/{}", path_, key)};
}

JsonPlace JsonPlace::element(std::size_t index) const {
    return {value_->at(index), subject_, fmt::format("{}/{}", path_, index)};
}

std::size_t JsonPlace::count(std::size_t least) const {
    if (!value_->is_array()) fail(least > 0 ? fmt::format("a list of at least {}", least) : "a list");
    if (value_->size() < least) fail(fmt::format("a list of at least {}", least));
    return value_->size();
}

void JsonPlace::object() const {
    if (!value_->is_object()) fail("an object");
}

bool JsonPlace::flag() const {
    if (!value_->is_boolean()) fail("true or false");
    return value_->get<bool>();
}

const std::string& JsonPlace::text() const {
    if (!value_->is_string()) fail("a string");
    return value_->get_ref<const std::string&>();
}

double JsonPlace::number(double low, double high) const {
    if (!value_->is_number() || !(value_->get<double>() >= low && value_->get<double>() <= high))
        fail(std::isfinite(low) || std::isfinite(high) ? fmt::format("a number from {} to {}", low, high) : "a number");
    return value_->get<double>();
}

std::int64_t JsonPlace::integer(std::int64_t low, std::int64_t high) const {
    const bool fits = value_->is_number_unsigned()
                          ? value_->get<std::uint64_t>() <= static_cast<std::uint64_t>(std::max<std::int64_t>(high, 0)) &&
                                (low <= 0 || value_->get<std::uint64_t>() >= static_cast<std::uint64_t>(low))
                          : value_->is_number_integer() && value_->get<std::int64_t>() >= low && value_->get<std::int64_t>() <= high;
    if (!fits) fail(fmt::format("an integer from {} to {}", low, high));
    return value_->get<std::int64_t>();
}

double JsonPlace::numberOrNull(double low, double high) const {
    return value_->is_null() ? HUGE_VAL : number(low, high);
}

std::size_t JsonPlace::oneOf(std::span<const std::string> names) const {
    const auto found = value_->is_string() ? std::ranges::find(names, value_->get_ref<const std::string&>()) : names.end();
    if (found == names.end()) fail(fmt::format("one of: {}", fmt::join(names, ", ")));
    return static_cast<std::size_t>(found - names.begin());
}

const std::string& JsonPlace::fileInFolder() const {
    const std::filesystem::path path = text();
    bool isInside = !path.empty() && path.is_relative() && path.has_filename() && text().find('\0') == std::string::npos;
    for (const auto& part : path) isInside = isInside && part != "..";
    if (!isInside) fail("the name of a file inside the cooked folder");
    return text();
}

}  // namespace lightcook::pipeline
