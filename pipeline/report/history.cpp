#include "pipeline/report/history.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sstream>

#include "formats/system_calls.h"
#include "pipeline/document/json.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/version.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// An open file that is locked against other programs until it is closed. One that this program makes, and has nothing to write to, goes
/// again.
class LockedFile {
public:
    explicit LockedFile(const std::filesystem::path& file) : file_(file) {
        // Another program that held the lock may have removed the file that it had made.
        do {
            close();
            isNew_ = open(O_EXCL);
            if (descriptor_ < 0 && errno == EEXIST) open(0);
            if (descriptor_ >= 0) formats::retried([&] { return ::flock(descriptor_, LOCK_EX); });
        } while (descriptor_ >= 0 && !isInPlace());
    }
    LockedFile(const LockedFile&) = delete;
    LockedFile& operator=(const LockedFile&) = delete;
    ~LockedFile() {
        if (descriptor_ >= 0 && isNew_) ::unlink(file_.c_str());
        close();
    }

    bool isOpen() const { return descriptor_ >= 0; }
    /// Appends a text whole. Else cuts the file to its old length, and returns false with the cause in errno.
    bool append(const std::string& text) {
        struct stat before {};
        if (::fstat(descriptor_, &before) != 0) return false;
        if (formats::writeWhole(descriptor_, text) && formats::retried([&] { return ::fsync(descriptor_); }) == 0) {
            isNew_ = false;
            return true;
        }
        const int cause = errno;
        [[maybe_unused]] const int cut = ::ftruncate(descriptor_, before.st_size);
        errno = cause;
        return false;
    }

private:
    bool open(int mode) {
        descriptor_ = formats::retried([&] { return ::open(file_.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC | mode, 0644); });
        return descriptor_ >= 0;
    }
    void close() {
        if (descriptor_ >= 0) ::close(descriptor_);
        descriptor_ = -1;
    }
    /// Returns true if the file of this name is the open one.
    bool isInPlace() const {
        struct stat own {
        }, named{};
        return ::fstat(descriptor_, &own) != 0 ||
               (::stat(file_.c_str(), &named) == 0 && own.st_dev == named.st_dev && own.st_ino == named.st_ino);
    }

    std::filesystem::path file_;
    int descriptor_ = -1;
    bool isNew_ = false;
};

/// Refuses a folder, and a device or a pipe, which has no lines to be read before the next one is appended.
Result<void> checkKind(const std::filesystem::path& file) {
    std::error_code code;
    if (std::filesystem::is_directory(file, code))
        return failure(ErrorCode::InvalidRequest, file, "found a folder, expected the name of a history file");
    if (std::filesystem::exists(file, code) && !std::filesystem::is_regular_file(file, code))
        return failure(ErrorCode::InvalidRequest, file, "found a device or a pipe, expected the name of a history file");
    return {};
}

Result<std::vector<HistoryLine>> linesOf(const std::string& text, const std::filesystem::path& file) {
    std::vector<HistoryLine> lines;
    std::istringstream stream(text);
    std::string each;
    for (std::size_t number = 1; std::getline(stream, each); ++number) {
        const formats::Subject place = formats::Subject::inLine(file, number);
        const Json json = parseJson(each);
        if (json.is_discarded() || !json.is_object() || !json.contains("lightcook") || (stream.eof() && !text.ends_with('\n')))
            return failure(ErrorCode::FileUnreadable, place,
                           "found no line of a history, expected what --history writes; name another file, or remove this line");
        LC_TRY(line, fromJson<HistoryLine>(json, place));
        lines.push_back(std::move(*line));
    }
    return lines;
}

}  // namespace

HistoryLine historyLine(const Report& report, std::string target) {
    HistoryLine line;
    line.lightcook = kToolVersion;
    line.at = report.runs.empty() ? timeNow() : report.runs.back().at;
    line.scene = report.scene;
    line.target = std::move(target);
    line.passed = report.passed;
    line.bytesGpu = report.budget.usedBytes;
    line.byKind = report.budget.byKind;
    for (const ReportRow& row : report.assets) {
        const AssetFigures figures = figuresOf(row);
        if (figures.diffuse) line.diffuse = std::max(line.diffuse.value_or(0.0), *figures.diffuse);
        if (figures.specular) line.specular = std::max(line.specular.value_or(0.0), *figures.specular);
        if (figures.visible) line.visible = std::max(line.visible.value_or(0.0), *figures.visible);
    }
    return line;
}

Result<std::vector<HistoryLine>> readHistory(const std::filesystem::path& file) {
    std::error_code code;
    LC_CHECK(checkKind(file));
    if (!std::filesystem::exists(file, code)) return std::vector<HistoryLine>();
    LC_TRY(text, readFile(file));
    return linesOf(*text, file);
}

Result<std::vector<HistoryLine>> appendHistory(const std::filesystem::path& file, const std::vector<HistoryLine>& lines) {
    // Read before the file is opened for writing: a wrong file is not touched.
    LC_CHECK(readHistory(file));
    LC_CHECK(makeFolder(file.parent_path()));
    LockedFile locked(file);
    if (!locked.isOpen())
        return failure(ErrorCode::Internal, file, fmt::format("found '{}', expected to append to this file", std::strerror(errno)));
    LC_TRY(history, readHistory(file));
    std::string text;
    for (const HistoryLine& line : lines) {
        const auto isOfScene = [&](const HistoryLine& each) { return each.scene == line.scene && each.target == line.target; };
        const auto last = std::find_if(history->rbegin(), history->rend(), isOfScene);
        if (last != history->rend() && jsonOf(*last) == jsonOf(line)) continue;
        text += toJson(line).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
        history->push_back(line);
    }
    if (!text.empty() && !locked.append(text))
        return failure(ErrorCode::Internal, file, fmt::format("found '{}', expected to append to this file", std::strerror(errno)));
    return history;
}

}  // namespace lightcook::pipeline
