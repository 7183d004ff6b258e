#include "pipeline/graph/user_settings.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "pipeline/graph/cache.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kVariables[] = {"XDG_CONFIG_HOME",
                                      "HOME",
                                      "XDG_CACHE_HOME",
                                      "LIGHTCOOK_CACHE",
                                      "LIGHTCOOK_REMOTE_CACHE",
                                      "LIGHTCOOK_REMOTE_UPLOAD",
                                      "LIGHTCOOK_REMOTE_CREDENTIALS"};

/// A user with a configuration file and no variables. The environment of the test comes back.
class UserSettingsFile : public testing::Test {
protected:
    UserSettingsFile() {
        for (const char* name : kVariables) {
            const char* const value = std::getenv(name);
            before_.push_back(value == nullptr ? std::nullopt : std::optional<std::string>(value));
            ::unsetenv(name);
        }
        set("XDG_CONFIG_HOME", folder_.path().string());
    }
    ~UserSettingsFile() override {
        for (std::size_t i = 0; i < before_.size(); ++i)
            before_[i] ? ::setenv(kVariables[i], before_[i]->c_str(), 1) : ::unsetenv(kVariables[i]);
    }
    UserSettingsFile(const UserSettingsFile&) = delete;
    UserSettingsFile& operator=(const UserSettingsFile&) = delete;

    static void set(const char* name, const std::string& value) { ::setenv(name, value.c_str(), 1); }
    std::filesystem::path file() const { return folder_ / "lightcook" / "config.toml"; }
    void write(const std::string& text) const {
        std::filesystem::create_directories(file().parent_path());
        formats::writeContent(file(), text);
    }
    static CacheSettings read(const GivenKeys& options = {}) {
        const auto settings = readUserSettings(options);
        EXPECT_TRUE(settings.has_value()) << settings.error().line();
        return settings ? settings->cache : CacheSettings();
    }
    static std::string errorOf(const GivenKeys& options = {}) {
        const auto settings = readUserSettings(options);
        EXPECT_FALSE(settings.has_value());
        return settings ? "" : settings.error().line();
    }

    formats::TemporaryFolder folder_;
    std::vector<std::optional<std::string>> before_;
};

constexpr const char* kWhole =
    "[cache]\nfolder = \"results\"\nremote_cache = \"https://cache.example.org/a\"\nremote_upload = true\nremote_credentials = "
    "\"/run/secret\"\n";

TEST_F(UserSettingsFile, NeedNotExist) {
    const CacheSettings none = read();
    EXPECT_FALSE(none.folder || none.remoteCache || none.remoteUpload || none.remoteCredentials || !none.credentials.empty());
    set("HOME", (folder_ / "home").string());
    EXPECT_EQ(*cacheFolder(""), folder_ / "home/.cache/lightcook");
    ::unsetenv("HOME");
    ::unsetenv("XDG_CONFIG_HOME");
    EXPECT_FALSE(read().folder.has_value());
}

TEST_F(UserSettingsFile, GivesWhatNeitherOptionNorVariableGives) {
    write(kWhole);
    CacheSettings settings = read();
    EXPECT_EQ(*settings.folder, folder_ / "lightcook/results") << "relative to the file";
    EXPECT_EQ(*cacheFolder(""), *settings.folder);
    EXPECT_EQ(*settings.remoteCache, "https://cache.example.org/a");
    EXPECT_TRUE(settings.remoteUpload);
    EXPECT_EQ(*settings.remoteCredentials, "/run/secret");

    set("LIGHTCOOK_CACHE", "/elsewhere");
    set("LIGHTCOOK_REMOTE_UPLOAD", "0");
    set("LIGHTCOOK_REMOTE_CREDENTIALS", "ci:other");
    settings = read();
    EXPECT_EQ(*cacheFolder(""), "/elsewhere");
    EXPECT_EQ(*cacheFolder("/option"), "/option");
    EXPECT_FALSE(settings.remoteUpload);
    EXPECT_EQ(settings.credentials, "ci:other");

    GivenKeys options;
    options.set("cache.remote_upload", "true");
    options.set("cache.remote_credentials", "here");
    settings = read(options);
    EXPECT_TRUE(settings.remoteUpload);
    EXPECT_EQ(*settings.remoteCredentials, std::filesystem::absolute("here")) << "relative to the current folder";
    EXPECT_EQ(settings.credentials, "");
}

/// A password must not go to whatever server a command line or a build names.
TEST_F(UserSettingsFile, CredentialsAreForTheAddressOfTheFileAlone) {
    write(kWhole);
    for (const auto& [address, isSame] :
         {std::pair("https://cache.example.org/a/", true), std::pair("https://cache.example.org:443/a", true),
          std::pair("http://cache.example.org/a", false), std::pair("https://cache.example.com/a", false),
          std::pair("https://cache.example.org/b", false)}) {
        GivenKeys options;
        options.set("cache.remote_cache", address);
        set("LIGHTCOOK_REMOTE_CACHE", "");
        for (const CacheSettings& settings : {read(options), (set("LIGHTCOOK_REMOTE_CACHE", address), read())}) {
            EXPECT_EQ(*settings.remoteCache, address);
            EXPECT_EQ(settings.remoteUpload, isSame) << address;
            EXPECT_EQ(settings.remoteCredentials.has_value(), isSame) << address;
        }
    }
    GivenKeys options;
    options.set("cache.remote_credentials", "/own");
    EXPECT_EQ(*read(options).remoteCredentials, "/own");
}

TEST_F(UserSettingsFile, IsFoundInTheHomeFolder) {
    std::filesystem::create_directories(folder_ / ".config/lightcook");
    formats::writeContent(folder_ / ".config/lightcook/config.toml", "[cache]\nfolder = \"/f\"\n");
    set("HOME", folder_.path().string());
    EXPECT_FALSE(read().folder.has_value());
    for (const char* invalid : {"", "relative"}) {
        set("XDG_CONFIG_HOME", invalid);
        EXPECT_EQ(*read().folder, "/f") << invalid;
    }
}

TEST_F(UserSettingsFile, MistakesAreNamedWithTheirPlace) {
    const std::string place = file().string();
    const auto refusalOf = [&](const std::string& text) {
        write(text);
        const std::string error = errorOf();
        EXPECT_FALSE(cacheFolder("").has_value()) << text;
        EXPECT_EQ(std::count(error.begin(), error.end(), '\n'), 0) << error;
        return error;
    };
    EXPECT_EQ(refusalOf("[cache]\nfoldre = \"a\"\n"),
              place + ":2:1: found unknown key 'foldre' in cache, expected one of its keys; nearest is 'folder'");
    EXPECT_THAT(refusalOf("[cash]\n"), StartsWith(place + ":1:2: found unknown key 'cash' in the configuration file, expected"));
    EXPECT_THAT(refusalOf("cache = 3\n"), StartsWith(place + ":1:9: found the integer 3 for 'cache', expected a table [cache]"));
    EXPECT_THAT(refusalOf("[cache]\nfolder = 3\n"), StartsWith(place + ":2:10: found the integer 3 for cache.folder, expected a path"));
    EXPECT_THAT(refusalOf("[cache]\nfolder = \"~/cache\"\n"), StartsWith(place + ":2:10: found '~' in the path '~/cache'"));
    EXPECT_THAT(refusalOf("[cache]\nremote_cache = \"cache.example.org\"\n"),
                StartsWith(place + ":2:16: found 'cache.example.org', expected the address of a cache, such as https://"));
    EXPECT_THAT(refusalOf("[cache]\nremote_cache = \"https://ci:secret@host\"\n"),
                AllOf(StartsWith(place + ":2:16: found an address with credentials"), Not(HasSubstr("secret"))));
    EXPECT_THAT(refusalOf("[cache]\nremote_upload = 1\n"), HasSubstr("found remote_upload without remote_cache"));
    EXPECT_THAT(refusalOf("[cache]\nremote_cache = \"http://a\"\nremote_upload = 1\n"),
                StartsWith(place + ":3:17: found the integer 1 for cache.remote_upload, expected true or false"));
    EXPECT_THAT(refusalOf("[cache\n"), HasSubstr("found a syntax error"));
    std::filesystem::remove(file());
    std::filesystem::create_directory(file());
    EXPECT_THAT(errorOf(), StartsWith(place + ": found "));
}

TEST_F(UserSettingsFile, MistakesInOptionsAndVariablesAreNamedByThem) {
    set("LIGHTCOOK_CACHE", "~/cache");
    EXPECT_THAT(errorOf(), StartsWith("$LIGHTCOOK_CACHE: found '~' in the path '~/cache'"));
    set("LIGHTCOOK_CACHE", "");
    set("LIGHTCOOK_REMOTE_UPLOAD", "yes");
    EXPECT_EQ(errorOf(), "$LIGHTCOOK_REMOTE_UPLOAD: found 'yes', expected true or false");
    set("LIGHTCOOK_REMOTE_UPLOAD", "1");
    EXPECT_TRUE(read().remoteUpload);
    set("LIGHTCOOK_REMOTE_CACHE", "ftp://a");
    EXPECT_THAT(errorOf(), StartsWith("$LIGHTCOOK_REMOTE_CACHE: found 'ftp://a', expected the address"));
    GivenKeys options;
    options.set("cache.remote_cache", "ftp://b");
    EXPECT_THAT(errorOf(options), StartsWith("--remote-cache: found 'ftp://b', expected the address"));
}

}  // namespace
}  // namespace lightcook::pipeline
