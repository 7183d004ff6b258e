// Keys of a TOML document that the command line gives. They are merged over the document before anything of it is read (toml_merge.h).
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace lightcook::pipeline {

struct GivenKey {
    std::string key;     ///< "output.target"; "light_map.phase": of every table [[light_map]]
    std::string value;   ///< as on the command line
    std::string option;  ///< that gave it, for messages: "--target"
};

/// Returns the option of a name with underscores: "--max-error" of max_error.
inline std::string optionNamed(std::string_view name) {
    std::string option = "--" + std::string(name);
    std::ranges::replace(option, '_', '-');
    return option;
}

class GivenKeys {
public:
    /// Gives a key a value, in place of an earlier one.
    /// option  empty: by the name of the key
    void set(const std::string& key, const std::string& value, const std::string& option = "") {
        std::erase_if(keys_, [&](const GivenKey& each) { return each.key == key; });
        keys_.push_back({key, value, option.empty() ? optionNamed(key.substr(key.rfind('.') + 1)) : option});
    }
    /// Does the same for a number or a boolean.
    template <class T>
    requires std::is_arithmetic_v<T>
    void set(const std::string& key, T value) { set(key, fmt::format("{}", value)); }

    /// Returns nullptr for a key that is not given.
    const GivenKey* find(std::string_view key) const {
        const auto found = std::ranges::find(keys_, key, &GivenKey::key);
        return found == keys_.end() ? nullptr : &*found;
    }
    /// Returns the keys less one.
    GivenKeys without(std::string_view key) const {
        GivenKeys others = *this;
        std::erase_if(others.keys_, [&](const GivenKey& each) { return each.key == key; });
        return others;
    }
    const std::vector<GivenKey>& all() const { return keys_; }

private:
    std::vector<GivenKey> keys_;
};

}  // namespace lightcook::pipeline
