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
/// Bazel 4.2.3 wrote this record through --remote_cache. The action makes an executable a.txt of "abc" and a folder, and prints a line.
const std::string kOfBazel =
    "126a0a2062617a656c2d6f75742f6b382d666173746275696c642f62696e2f612e74787412440a406261373831366266386630316366656134313431"
    "3430646535646165323232336230303336316133393631373761396362343130666636316632303031356164100320011a690a2162617a656c2d6f75"
    "742f6b382d666173746275696c642f62696e2f666f6c6465721a440a4034323663393661623137363630353166363862353564316232323436356562"
    "366161626437613962363562666562663762636263626130663133303235363631104d32440a40616630633166353131313030313032343264316666"
    "65643033616432386531623666353934653761646535333466653634353634653531663233633362353066100542420a406533623063343432393866"
    "6331633134396166626634633839393666623932343237616534316534363439623933346361343935393931623738353262383535";
/// moon 2.5.5 wrote this record for a task with two files.
const std::string kOfMoon =
    R"({"outputFiles":[{"path":"app/out/deep/x.txt","digest":{"hash":"73cb3858a687a8494ca3323053016282f3dad39d42cf62ca4e79dda2aac7d9ac",)"
    R"("sizeBytes":"2"},"nodeProperties":{"mtime":"2026-12-01T04:25:24.412160415+00:00","unixMode":33188}},{"path":"app/out/sum.txt",)"
    R"("digest":{"hash":"fb77cfb175bd0fdb4157d7a342aee187a454fa6083700d2366e3584c5e2342ee","sizeBytes":"73"},"nodeProperties":{"mtime":)"
    R"("2026-12-01T04:25:24.412160415+00:00","unixMode":33188}}],"stdoutDigest":{"hash":)"
    R"("af0c1f51110010242d1ffed03ad28e1b6f594e7ade534fe64564e51f23c3b50f","sizeBytes":"5"},"executionMetadata":{"worker":"moon",)"
    R"("outputUploadStartTimestamp":"2026-12-01T04:25:24.427509238+00:00"}})";

TEST(ActionResult, IsWhatProtobufWrites) {
    const std::vector<OutputFile> files = {{"a/b.ktx2", kHash, 300}, {"none", kHash, 0}};
    EXPECT_EQ(hexOf(actionResultText(files)), kTwoFiles);
    EXPECT_EQ(readActionResult(bytesOf(kTwoFiles)), files);
    EXPECT_EQ(readActionResult(bytesOf(kMoreFields)), std::vector<OutputFile>{files[0]});
}

TEST(ActionResult, WhatOtherClientsWroteIsRead) {
    EXPECT_EQ(readActionResult(bytesOf(kOfBazel)), (std::vector<OutputFile>{{"bazel-out/k8-fastbuild/bin/a.txt", sha256OfText("abc"), 3}}));
    EXPECT_EQ(readActionResult(kOfMoon),
              (std::vector<OutputFile>{{"app/out/deep/x.txt", sha256OfText("x\n"), 2},
                                       {"app/out/sum.txt", "fb77cfb175bd0fdb4157d7a342aee187a454fa6083700d2366e3584c5e2342ee", 73}}));
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
    for (const char* code : {"1", "-1", "\"1\""})  // that of a signal is negative
        EXPECT_FALSE(readActionResult(
            fmt::format(R"({{"exitCode": {}, "outputFiles": [{{"path": "a", "digest": {{{}"sizeBytes": 1}}}}]}})", code, digest)))
            << code;
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
