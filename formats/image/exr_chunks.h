// The chunks of an OpenEXR file as the file stores them: whole, compressed or not, without decoding.
#pragma once

#include <memory>
#include <string>

#include "formats/image/exr_file.h"

namespace lightcook::formats {

class ExrChunks {
public:
    /// descriptor  of a file with one flat part. It stays open as long as this object
    ExrChunks(int descriptor, const ExrInfo& info);
    ~ExrChunks();
    ExrChunks(const ExrChunks&) = delete;
    ExrChunks& operator=(const ExrChunks&) = delete;

    /// Returns a digest of the chunks that hold rows [firstRow, firstRow + rowCount), and of all that decides what their bytes mean: also
    /// the chromaticities. Empty: a chunk is not there whole, or the header has something that OpenEXR's C library refuses.
    std::string digestOf(int firstRow, int rowCount) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace lightcook::formats
