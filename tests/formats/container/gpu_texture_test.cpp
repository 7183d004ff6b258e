#include "formats/gpu_texture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "formats/container/ktx2.h"
#include "tests/formats/temporary_folder.h"
#include "tests/formats/texture_fixture.h"

namespace lightcook::formats {
namespace {

using testing::HasSubstr;

struct Kind {
    const char* name;
    Container container;
    bool zstd;
};
constexpr std::array kKinds = {Kind{"ktx2", Container::Ktx2, false}, Kind{"ktx2-zstd", Container::Ktx2, true},
                               Kind{"dds", Container::Dds, false}};

TextureFileOptions optionsOf(const Kind& kind) {
    TextureFileOptions options;
    options.container = kind.container;
    options.zstd = kind.zstd;
    options.zstdLevel = 3;
    return options;
}

bool canHold(const Kind& kind, PixelFormat format) {
    return kind.container == Container::Ktx2 || info(format).dxgiFormat != 0;
}

void expectPattern(const TextureReader& reader, const TextureShape& shape) {
    for (const SubImage& image : allImages(shape)) {
        const Result<std::vector<std::byte>> bytes = reader.readImage(image);
        ASSERT_TRUE(bytes) << bytes.error().line();
        EXPECT_TRUE(*bytes == patternImage(shape, image)) << "mip " << image.mip << " layer " << image.layer << " face " << image.face;
    }
}

TEST(PixelFormat, NamesAreUniqueAndFound) {
    for (const PixelFormatInfo& format : allPixelFormats()) EXPECT_EQ(pixelFormatFromName(format.name), format.format);
    EXPECT_FALSE(pixelFormatFromName("bc2"));
}

TEST(PixelFormat, PartialBlocksCountAsWhole) {
    EXPECT_EQ(blocksAcross(PixelFormat::Astc6x6Hdr, 1), 1);
    EXPECT_EQ(blocksAcross(PixelFormat::Astc6x6Hdr, 12), 2);
    EXPECT_EQ(blocksDown(PixelFormat::Bc7, 13), 4);
    EXPECT_EQ(bytesPerImage(PixelFormat::Bc1, 5, 5), 32u);
    EXPECT_EQ(bytesPerImage(PixelFormat::Rgb16f, 3, 2), 36u);
}

class EveryFormat : public testing::TestWithParam<PixelFormatInfo> {};

TEST_P(EveryFormat, ComesBackFromEveryContainerAndShape) {
    const TemporaryFolder folder;
    for (const Kind& kind : kKinds) {
        if (!canHold(kind, GetParam().format)) continue;
        for (const NamedShape& named : shapesOf(GetParam().format)) {
            SCOPED_TRACE(std::string(kind.name) + " " + named.name);
            const std::filesystem::path file = folder / "texture";
            const Result<void> written = writePattern(file, named.shape, optionsOf(kind));
            ASSERT_TRUE(written) << written.error().line();
            const Result<TextureReader> reader = TextureReader::open(file);
            ASSERT_TRUE(reader) << reader.error().line();
            const TextureShape& shape = reader->shape();
            EXPECT_EQ(shape.format, named.shape.format);
            EXPECT_EQ(shape.width, named.shape.width);
            EXPECT_EQ(shape.height, named.shape.height);
            EXPECT_EQ(shape.mipCount, named.shape.mipCount);
            EXPECT_EQ(shape.layerCount, named.shape.layerCount);
            EXPECT_EQ(shape.faceCount, named.shape.faceCount);
            // DDS cannot tell an array of one from no array.
            EXPECT_EQ(shape.isArray, kind.container == Container::Dds ? named.shape.layerCount > 1 : named.shape.isArray);
            EXPECT_EQ(reader->isZstd(), kind.zstd);
            EXPECT_EQ(reader->container(), kind.container);
            EXPECT_EQ(reader->fileBytes(), std::filesystem::file_size(file));
            expectPattern(*reader, named.shape);
        }
    }
}

TEST_P(EveryFormat, OrderOfWritingLeavesTheSameBytes) {
    const TemporaryFolder folder;
    const TextureShape shape{GetParam().format, 19, 19, 5, 2, true, 6};
    for (const Kind& kind : kKinds) {
        if (!canHold(kind, shape.format)) continue;
        ASSERT_TRUE(writePattern(folder / "forwards", shape, optionsOf(kind), false));
        ASSERT_TRUE(writePattern(folder / "backwards", shape, optionsOf(kind), true));
        EXPECT_TRUE(wholeFile(folder / "forwards") == wholeFile(folder / "backwards")) << kind.name;
    }
}

TEST_P(EveryFormat, EveryTruncationIsRefused) {
    const TemporaryFolder folder;
    const TextureShape shape{GetParam().format, 5, 5, 2, 1, false, 1};
    const std::filesystem::path file = folder / "texture";
    for (const Kind& kind : kKinds) {
        if (!canHold(kind, shape.format)) continue;
        ASSERT_TRUE(writePattern(file, shape, optionsOf(kind)));
        for (std::uintmax_t length = std::filesystem::file_size(file); length-- > 0;) {
            std::filesystem::resize_file(file, length);
            const Result<TextureReader> reader = TextureReader::open(file);
            ASSERT_FALSE(reader) << kind.name << " cut to " << length;
            EXPECT_THAT(reader.error().line(), HasSubstr("found"));
        }
    }
}

TEST_P(EveryFormat, AnyWrongByteIsReadOrRefusedButNeverWorse) {
    const TemporaryFolder folder;
    const TextureShape shape{GetParam().format, 5, 5, 2, 1, false, 1};
    for (const Kind& kind : kKinds) {
        if (!canHold(kind, shape.format)) continue;
        ASSERT_TRUE(writePattern(folder / "texture", shape, optionsOf(kind)));
        const std::vector<std::byte> bytes = wholeFile(folder / "texture");
        const Result<FileBytes> file = FileBytes::openForUpdate(folder / "texture", folder / "texture");
        ASSERT_TRUE(file);
        int refused = 0, accepted = 0;
        for (std::size_t at = 0; at < bytes.size(); ++at)
            for (const int flip : {0x01, 0x80, 0xff, 0}) {  // 0 puts it right again
                const std::byte byte = bytes[at] ^ static_cast<std::byte>(flip);
                ASSERT_TRUE(file->writeAt(at, std::span(&byte, 1)));
                const Result<TextureReader> reader = TextureReader::open(folder / "texture");
                bool isGood = reader.has_value();
                if (reader)
                    for (const SubImage& image : allImages(reader->shape())) isGood &= reader->readImage(image).has_value();
                ASSERT_TRUE(isGood || flip != 0);
                ++(isGood ? accepted : refused);
            }
        EXPECT_GT(refused, 30) << kind.name;
        EXPECT_GT(accepted, 0) << kind.name;  // texels without a checksum, primaries, ...
    }
}

INSTANTIATE_TEST_SUITE_P(GpuTexture, EveryFormat, testing::ValuesIn(std::vector(allPixelFormats().begin(), allPixelFormats().end())),
                         [](const auto& instance) {
                             std::string name(instance.param.name);
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

TEST(GpuTexture, EveryWrongByteOfACompressedLevelIsRefused) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Bc7, 64, 64, 1, 1, false, 1};
    ASSERT_TRUE(writePattern(folder / "whole", shape, optionsOf(kKinds[1])));
    const std::vector<std::byte> bytes = wholeFile(folder / "whole");
    const Result<FileBytes> file = FileBytes::openForUpdate(folder / "whole", folder / "whole");
    ASSERT_TRUE(file);
    for (std::size_t at = static_cast<std::size_t>(loadU64(bytes, 80)); at < bytes.size(); ++at) {
        const std::byte wrong = bytes[at] ^ std::byte{0x10};
        ASSERT_TRUE(file->writeAt(at, std::span(&wrong, 1)));
        const Result<TextureReader> reader = TextureReader::open(folder / "whole");
        ASSERT_TRUE(reader);
        const Result<std::vector<std::byte>> image = reader->readImage({});
        // A flip that Zstandard ignores (an unused header bit) may only leave the texels as they were.
        EXPECT_TRUE(!image || *image == patternImage(shape, {})) << "byte " << at;
        ASSERT_TRUE(file->writeAt(at, std::span(&bytes[at], 1)));
    }
}

TEST(GpuTexture, SizesThatTheFileCannotHoldAreRefusedBeforeTheyAreAllocated) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Rgba16f, 4, 4, 1, 1, false, 1};
    for (const Kind& kind : kKinds) {
        ASSERT_TRUE(writePattern(folder / "whole", shape, optionsOf(kind)));
        std::vector<std::byte> bytes = wholeFile(folder / "whole");
        const std::size_t widthAt = kind.container == Container::Ktx2 ? 20 : 16, heightAt = kind.container == Container::Ktx2 ? 24 : 12;
        for (const std::uint32_t extent : {0u, 65536u, 65537u, 0x80000000u, 0xffffffffu}) {
            std::vector<std::byte> little;
            appendU32(little, extent);
            std::copy(little.begin(), little.end(), bytes.begin() + static_cast<std::ptrdiff_t>(widthAt));
            std::copy(little.begin(), little.end(), bytes.begin() + static_cast<std::ptrdiff_t>(heightAt));
            putFile(folder / "bad", bytes);
            EXPECT_FALSE(TextureReader::open(folder / "bad")) << kind.name << " " << extent;
        }
    }
}

TEST(GpuTexture, NothingStaysBehindWithoutCommit) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Bc1, 16, 16, 1, 1, false, 1};
    for (const Kind& kind : kKinds) {
        {
            Result<TextureWriter> writer = TextureWriter::create(folder / "texture", shape, optionsOf(kind));
            ASSERT_TRUE(writer);
            ASSERT_TRUE(writer->writeBlockRows({}, 0, patternImage(shape, {})));
            EXPECT_FALSE(std::filesystem::exists(folder / "texture"));
        }
        EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << kind.name;
    }
    ASSERT_TRUE(writePattern(folder / "texture", shape, optionsOf(kKinds[1])));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(GpuTexture, CommitWithRowsMissingFailsAndLeavesTheOldFile) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Bc1, 16, 16, 1, 1, false, 1};
    ASSERT_TRUE(writePattern(folder / "texture", shape, optionsOf(kKinds[0])));
    const std::vector<std::byte> before = wholeFile(folder / "texture");
    {
        Result<TextureWriter> writer = TextureWriter::create(folder / "texture", shape, optionsOf(kKinds[0]));
        ASSERT_TRUE(writer);
        ASSERT_TRUE(writer->writeBlockRows({}, 1, std::vector<std::byte>(32)));
        const Result<void> done = writer->commit();
        ASSERT_FALSE(done);
        EXPECT_THAT(done.error().line(), HasSubstr("found 32 bytes"));
    }
    EXPECT_TRUE(wholeFile(folder / "texture") == before);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(GpuTexture, RowsOutsideTheImageAreRefused) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Bc1, 16, 16, 1, 1, false, 1};
    Result<TextureWriter> writer = TextureWriter::create(folder / "texture", shape, {});
    ASSERT_TRUE(writer);
    EXPECT_FALSE(writer->writeBlockRows({}, 4, std::vector<std::byte>(32)));
    EXPECT_FALSE(writer->writeBlockRows({}, -1, std::vector<std::byte>(32)));
    EXPECT_FALSE(writer->writeBlockRows({}, 3, std::vector<std::byte>(64)));
    EXPECT_FALSE(writer->writeBlockRows({}, 0, std::vector<std::byte>(31)));
    EXPECT_FALSE(writer->writeBlockRows({1, 0, 0}, 0, std::vector<std::byte>(32)));
    EXPECT_FALSE(writer->writeBlockRows({0, 0, 1}, 0, std::vector<std::byte>(32)));
    EXPECT_FALSE(writer->writeBlockRows({0, 1, 0}, 0, std::vector<std::byte>(32)));
}

TEST(GpuTexture, ThreadsMayWriteAndReadRowsAtOnce) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Bc7, 256, 256, 1, 1, false, 1};
    const std::vector<std::byte> image = patternImage(shape, {});
    const std::size_t rowBytes = bytesPerBlockRow(shape.format, shape.width);
    const auto onThreads = [](const auto& work) {
        std::vector<std::thread> threads;
        for (int t = 0; t < 4; ++t)
            threads.emplace_back([&work, t] {
                for (int row = t; row < 64; row += 4) work(row);
            });
        for (std::thread& thread : threads) thread.join();
    };
    for (const Kind& kind : kKinds) {
        Result<TextureWriter> writer = TextureWriter::create(folder / "threads", shape, optionsOf(kind));
        ASSERT_TRUE(writer);
        onThreads([&](int row) {
            EXPECT_TRUE(writer->writeBlockRows({}, row, std::span(image).subspan(static_cast<std::size_t>(row) * rowBytes, rowBytes)));
        });
        ASSERT_TRUE(writer->commit());
        ASSERT_TRUE(writePattern(folder / "serial", shape, optionsOf(kind)));
        EXPECT_TRUE(wholeFile(folder / "threads") == wholeFile(folder / "serial")) << kind.name;
        const Result<TextureReader> reader = TextureReader::open(folder / "threads");
        ASSERT_TRUE(reader);
        std::vector<std::byte> read(image.size());
        onThreads([&](int row) {
            EXPECT_TRUE(reader->readBlockRows({}, row, std::span(read).subspan(static_cast<std::size_t>(row) * rowBytes, rowBytes)));
        });
        EXPECT_TRUE(read == image) << kind.name;
    }
}

TEST(GpuTexture, LevelsLargerThanOnePieceGoThroughZstandard) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Rgba16f, 1024, 700, 2, 1, false, 1};  // 5.7 MB and 1.4 MB; pieces are of 1 MiB
    ASSERT_TRUE(writePattern(folder / "large", shape, optionsOf(kKinds[1])));
    const Result<TextureReader> reader = TextureReader::open(folder / "large");
    ASSERT_TRUE(reader);
    EXPECT_LT(reader->fileBytes(), shape.gpuBytes() * 6 / 10);
    expectPattern(*reader, shape);
}

/// Returns noise in which halves of blocks repeat at other places, like blocks after rate-distortion optimization.
TEST(GpuTexture, ShortRepeatsAreFoundAtTheDefaultLevelAndComeBack) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Bc7, 256, 256, 1, 1, false, 1};
    std::vector<std::byte> bytes(shape.gpuBytes());
    std::uint32_t state = 1;
    for (std::byte& each : bytes) each = static_cast<std::byte>((state = state * 1664525u + 1013904223u) >> 24);
    constexpr std::size_t kBlock = 16, kHalf = 6;
    for (std::size_t block = 40; block < bytes.size() / kBlock; ++block)
        std::copy_n(bytes.data() + kBlock * (block - 1 - block % 37), kHalf, bytes.data() + kBlock * block);
    const auto fileBytes = [&](int level) {
        TextureFileOptions options;
        options.zstd = true;
        if (level != 0) options.zstdLevel = level;
        auto writer = TextureWriter::create(folder / "texture", shape, options);
        EXPECT_TRUE(writer && writer->writeBlockRows({}, 0, bytes) && writer->commit());
        const Result<TextureReader> reader = TextureReader::open(folder / "texture");
        EXPECT_TRUE(reader && reader->readImage({}) == bytes);
        return reader->fileBytes();
    };
    const auto atDefault = fileBytes(0);
    EXPECT_LT(atDefault, fileBytes(9));
    for (const int level : {1, 17, 18, 22}) fileBytes(level);
}

TEST(GpuTexture, MetadataComesBackFromKtx2) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::R16Unorm, 3, 3, 1, 1, false, 1};
    for (const Kind& kind : {kKinds[0], kKinds[1]}) {
        TextureFileOptions options = optionsOf(kind);
        options.metadata = {{"lightcook.range", "{\"scale\":2}"}, {"a", ""}, {"z", std::string("with\0nul", 8)}};
        ASSERT_TRUE(writePattern(folder / "texture", shape, options));
        const Result<TextureReader> reader = TextureReader::open(folder / "texture");
        ASSERT_TRUE(reader);
        std::map<std::string, std::string> expected = options.metadata;
        expected["KTXwriter"] = "lightcook 0.1.0";
        expected["KTXorientation"] = "rd";
        EXPECT_EQ(reader->metadata(), expected);
    }
}

TEST(GpuTexture, RequestsThatNoFileCanHonourAreRefused) {
    const TemporaryFolder folder;
    const auto refused = [&](const TextureShape& shape, const TextureFileOptions& options, ErrorCode code) {
        const Result<TextureWriter> writer = TextureWriter::create(folder / "texture", shape, options);
        ASSERT_FALSE(writer);
        EXPECT_EQ(writer.error().code, code) << writer.error().line();
        EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
    };
    const TextureShape good{PixelFormat::Bc1, 16, 16, 1, 1, false, 1};
    const auto with = [&](auto change) {
        TextureShape shape = good;
        change(shape);
        return shape;
    };
    refused(with([](TextureShape& s) { s.width = 0; }), {}, ErrorCode::InvalidRequest);
    refused(with([](TextureShape& s) { s.height = 70000; }), {}, ErrorCode::InvalidRequest);
    refused(with([](TextureShape& s) { s.mipCount = 6; }), {}, ErrorCode::InvalidRequest);
    refused(with([](TextureShape& s) { s.layerCount = 2; }), {}, ErrorCode::InvalidRequest);
    refused(with([](TextureShape& s) { s.faceCount = 3; }), {}, ErrorCode::InvalidRequest);
    refused(with([](TextureShape& s) { s.faceCount = 6, s.height = 8; }), {}, ErrorCode::InvalidRequest);
    for (const PixelFormatInfo& format : allPixelFormats())
        if (format.dxgiFormat == 0)
            refused(with([&](TextureShape& s) { s.format = format.format; }), optionsOf(kKinds[2]), ErrorCode::FormatUnsupported);
    TextureFileOptions options = optionsOf(kKinds[2]);
    options.zstd = true;
    refused(good, options, ErrorCode::InvalidRequest);
    options = optionsOf(kKinds[1]);
    options.zstdLevel = 100;
    refused(good, options, ErrorCode::InvalidRequest);
    for (const std::string& key : {std::string(), std::string("KTXwriter"), std::string("a\0b", 3)}) {
        options = optionsOf(kKinds[0]);
        options.metadata = {{key, "value"}};
        refused(good, options, ErrorCode::InvalidRequest);
    }
    EXPECT_FALSE(TextureWriter::create(folder / "no-such-folder" / "texture", good, {}));
}

TEST(GpuTexture, MeaningsThatWeCannotHonourAreRefused) {
    const TemporaryFolder folder;
    const TextureShape shape{PixelFormat::Bc1, 4, 4, 1, 1, false, 1};
    ASSERT_TRUE(writePattern(folder / "texture", shape, {}));
    std::vector<std::byte> bytes = wholeFile(folder / "texture");
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t at = text.find("KTXorientation") + 15;
    ASSERT_EQ(text.substr(at, 2), "rd");
    bytes[at + 1] = std::byte{'u'};
    putFile(folder / "texture", bytes);
    const Result<TextureReader> reader = TextureReader::open(folder / "texture");
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.error().code, ErrorCode::FormatUnsupported);
    EXPECT_THAT(reader.error().line(), HasSubstr("found ru, expected rd"));
}

TEST(GpuTexture, OtherFilesAreRefusedByName) {
    const TemporaryFolder folder;
    EXPECT_EQ(TextureReader::open(folder / "missing").error().code, ErrorCode::FileUnreadable);
    EXPECT_EQ(TextureReader::open(folder.path()).error().code, ErrorCode::FileUnreadable);
    putFile(folder / "text", std::vector<std::byte>(500, std::byte{'x'}));
    EXPECT_EQ(TextureReader::open(folder / "text").error().code, ErrorCode::FormatUnsupported);
    for (const char* name : {"missing", "", "text"}) {
        EXPECT_FALSE(containerOfContent(folder / name)) << name;
        EXPECT_FALSE(textureForImage(folder / name, "an image")) << name;
    }
}

}  // namespace
}  // namespace lightcook::formats
