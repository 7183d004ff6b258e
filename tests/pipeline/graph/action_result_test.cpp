#include "pipeline/graph/action_result.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pipeline/graph/sha256.h"

namespace lightcook::pipeline {
namespace {

const std::string kHash = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

std::string bytesOf(const std::string& hex) {
    std::string bytes;
    for (std::size_t i = 0; i < hex.size(); i += 2) bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
    return bytes;
}
std::string hexOf(const std::string& bytes) {
    std::string hex;
    for (const char byte : bytes) hex += fmt::format("{:02x}", static_cast<unsigned char>(byte));
    return hex;
}

// By `protoc --encode` of protobuf 3.21.
const std::string kTwoFiles = "12510a08612f622e6b74783212450a40" + hexOf(kHash) + "10ac02" + "124a0a046e6f6e6512420a40" + hexOf(kHash);
/// A file with its content and an executable bit, standard output, and who ran the action.
const std::string kMoreFields =
    "12580a08612f622e6b74783212450a40" + hexOf(kHash) + "10ac0220012a0378797a2a05776f72647332070a0361626310054a030a0177";

TEST(ActionResult, IsWhatProtobufWrites) {
    const std::vector<OutputFile> files = {{"a/b.ktx2", kHash, 300}, {"none", kHash, 0}};
    EXPECT_EQ(hexOf(actionResultText(files)), kTwoFiles);
    EXPECT_EQ(readActionResult(bytesOf(kTwoFiles)), files);
    EXPECT_EQ(readActionResult(bytesOf(kMoreFields)), std::vector<OutputFile>{files[0]});
}

TEST(ActionResult, JsonIsRead) {
    const std::vector<OutputFile> files = {{"a", kHash, 300}};
    const std::string digest = fmt::format(R"("hash": "{}", )", kHash);
    EXPECT_EQ(readActionResult(R"({"outputFiles": [{"path": "a", "digest": {)" + digest + R"("sizeBytes": "300"}}], "exitCode": 0})"),
              files);
    EXPECT_EQ(readActionResult(R"({"output_files": [{"path": "a", "digest": {)" + digest + R"("size_bytes": 300}}]})"), files);
    for (const char* wrong : {"{", "{}", R"({"outputFiles": []})", R"({"outputFiles": "a"})", R"({"outputFiles": [1]})",
                              R"({"outputFiles": [{"path": "a"}]})", R"({"outputFiles": [{"path": "a", "digest": {"hash": "ab"}}]})"})
        EXPECT_FALSE(readActionResult(wrong).has_value()) << wrong;
    EXPECT_FALSE(readActionResult(R"({"outputFiles": [{"path": "a", "digest": {)" + digest + R"("sizeBytes": -1}}]})").has_value());
    EXPECT_FALSE(readActionResult(R"({"exitCode": 1, "outputFiles": [{"path": "a", "digest": {)" + digest + R"("sizeBytes": 1}}]})"));
}

TEST(ActionResult, WhatIsEmptyTornOrFailedIsRefused) {
    const std::string whole = bytesOf(kMoreFields);
    EXPECT_FALSE(readActionResult("").has_value());
    EXPECT_FALSE(readActionResult(bytesOf("2001") + whole).has_value()) << "exit code 1";
    EXPECT_TRUE(readActionResult(bytesOf("2000") + whole).has_value());
    for (std::size_t size = 1; size < 90; ++size)
        EXPECT_FALSE(readActionResult(whole.substr(0, size)).has_value()) << size << " bytes, which end within the output file";
    for (std::size_t at = 0; at < whole.size(); ++at)
        for (const char byte : {'\x00', '\x7f', '\xff'}) {
            std::string damaged = whole;
            damaged[at] = byte;
            (void)readActionResult(damaged);  // ends
        }
}

TEST(Sha256, IsThatOfTheStandard) {
    EXPECT_EQ(sha256OfText(""), kHash);
    EXPECT_EQ(sha256OfText("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");  // FIPS 180-2, appendix B.1
}

}  // namespace
}  // namespace lightcook::pipeline
