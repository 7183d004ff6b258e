#include "pipeline/graph/action_result.h"

#include <algorithm>
#include <charconv>

#include "pipeline/document/json.h"

namespace lightcook::pipeline {
namespace {

// Numbers of fields in remote_execution.proto.
enum ActionResultField : std::uint64_t { kOutputFiles = 2, kExitCode = 4 };
enum OutputFileField : std::uint64_t { kPath = 1, kDigest = 2 };
enum DigestField : std::uint64_t { kHash = 1, kSizeBytes = 2 };
// Wire types of protobuf.
enum WireType : std::uint64_t { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };

void addVarint(std::string& text, std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) text += static_cast<char>(value | 0x80);
    text += static_cast<char>(value);
}
void addBytes(std::string& text, std::uint64_t field, std::string_view bytes) {
    addVarint(text, field << 3 | kBytes);
    addVarint(text, bytes.size());
    text += bytes;
}

std::optional<std::uint64_t> takeVarint(std::string_view& text) {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64 && !text.empty(); shift += 7) {
        const auto byte = static_cast<unsigned char>(text[0]);
        text.remove_prefix(1);
        value |= std::uint64_t{byte & 0x7fu} << shift;
        if (byte < 0x80) return value;
    }
    return std::nullopt;
}
std::optional<std::string_view> take(std::string_view& text, std::uint64_t size) {
    if (size > text.size()) return std::nullopt;
    const std::string_view bytes = text.substr(0, size);
    text.remove_prefix(size);
    return bytes;
}

/// Calls onField(field, number, bytes) for each field of a message, and returns false if it is damaged or onField() says so.
template <class OnField>
bool eachField(std::string_view message, const OnField& onField) {
    while (!message.empty()) {
        const auto tag = takeVarint(message);
        if (!tag) return false;
        std::optional<std::uint64_t> number = 0;
        std::optional<std::string_view> bytes = "";
        switch (*tag & 7) {
            case kVarint:
                number = takeVarint(message);
                break;
            case kBytes:
                number = takeVarint(message);
                bytes = number ? take(message, *number) : std::nullopt;
                break;
            case kFixed64:
                bytes = take(message, 8);
                break;
            case kFixed32:
                bytes = take(message, 4);
                break;
            default:
                return false;
        }
        if (!number || !bytes || !onField(*tag >> 3, *number, *bytes)) return false;
    }
    return true;
}

bool isDigest(std::string_view text) {
    return text.size() == 64 &&
           std::all_of(text.begin(), text.end(), [](char c) { return ('0' <= c && c <= '9') || ('a' <= c && c <= 'f'); });
}

std::optional<std::vector<OutputFile>> readMessage(std::string_view text) {
    std::vector<OutputFile> files;
    const auto readDigest = [&](std::uint64_t field, std::uint64_t number, std::string_view bytes) {
        if (field == kHash) files.back().sha256 = bytes;
        if (field == kSizeBytes) files.back().bytes = number;
        return true;
    };
    const auto readFile = [&](std::uint64_t field, std::uint64_t, std::string_view bytes) {
        if (field == kPath) files.back().path = bytes;
        return field != kDigest || eachField(bytes, readDigest);
    };
    const auto readResult = [&](std::uint64_t field, std::uint64_t number, std::string_view bytes) {
        if (field == kExitCode) return number == 0;
        if (field != kOutputFiles) return true;
        files.emplace_back();
        return eachField(bytes, readFile);
    };
    return eachField(text, readResult) ? std::optional(std::move(files)) : std::nullopt;
}

/// Returns the value of a field under either of its names in protobuf's JSON.
Json valueOf(const Json& object, const char* lowerCamel, const char* original) {
    return object.contains(lowerCamel) ? object[lowerCamel] : object.value(original, Json());
}

std::optional<std::vector<OutputFile>> readJson(const std::string& text) {
    const Json json = parseJson(text);
    if (!json.is_object()) return std::nullopt;
    if (const Json code = valueOf(json, "exitCode", "exit_code"); !code.is_null() && code != 0) return std::nullopt;
    std::vector<OutputFile> files;
    for (const Json& each : valueOf(json, "outputFiles", "output_files")) {
        const Json digest = each.is_object() ? each.value("digest", Json()) : Json();
        if (!digest.is_object() || !each.contains("path") || !each["path"].is_string()) return std::nullopt;
        const Json hash = digest.value("hash", Json()), size = valueOf(digest, "sizeBytes", "size_bytes");
        OutputFile file{each["path"].get<std::string>(), hash.is_string() ? hash.get<std::string>() : "", 0};
        if (size.is_string()) {  // protobuf writes 64 bits as a text
            const std::string number = size.get<std::string>();
            if (std::from_chars(number.data(), number.data() + number.size(), file.bytes).ec != std::errc()) return std::nullopt;
        } else if (size.is_number_unsigned()) {
            file.bytes = size.get<std::uint64_t>();
        } else if (!size.is_null()) {
            return std::nullopt;
        }
        files.push_back(std::move(file));
    }
    return files;
}

}  // namespace

std::string actionResultText(const std::vector<OutputFile>& files) {
    std::string result;
    for (const OutputFile& file : files) {
        std::string digest, output;
        addBytes(digest, kHash, file.sha256);
        if (file.bytes > 0) {  // protobuf leaves a zero out
            addVarint(digest, kSizeBytes << 3 | kVarint);
            addVarint(digest, file.bytes);
        }
        addBytes(output, kPath, file.path);
        addBytes(output, kDigest, digest);
        addBytes(result, kOutputFiles, output);
    }
    return result;
}

std::optional<std::vector<OutputFile>> readActionResult(const std::string& text) {
    auto files = text.starts_with('{') ? readJson(text) : readMessage(text);
    if (!files || files->empty()) return std::nullopt;
    for (const OutputFile& file : *files)
        if (file.path.empty() || !isDigest(file.sha256)) return std::nullopt;
    return files;
}

}  // namespace lightcook::pipeline
