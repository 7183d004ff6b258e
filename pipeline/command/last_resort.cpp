#include "pipeline/command/last_resort.h"

#include <cxxabi.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <string_view>
#include <typeinfo>

#include "formats/system_calls.h"
#include "formats/temporaries.h"
#include "pipeline/graph/version.h"

namespace lightcook::pipeline {
namespace {

constexpr int kInternalCode = 1;  ///< exitCode(ErrorCode::Internal)

std::atomic<LogFormat> logFormat{LogFormat::Text};
std::atomic<bool> isEnding{false};
thread_local bool isEndedHere = false;

/// A line that is put together without memory of the heap.
class Line {
public:
    Line& operator<<(std::string_view text) {
        const std::size_t count = std::min(text.size(), sizeof text_ - size_);
        std::memcpy(text_ + size_, text.data(), count);
        size_ += count;
        return *this;
    }
    void print() const { (void)formats::writeWhole(STDERR_FILENO, {text_, size_}); }

private:
    char text_[512];
    std::size_t size_ = 0;
};

void printError(std::string_view subject, std::string_view detail) {
    Line line;
    if (logFormat == LogFormat::JsonLines)
        line << R"({"level":"error","code":1,"subject":")" << subject << R"(","detail":")" << detail << "\"}\n";
    else
        line << (takesEscapes(STDERR_FILENO) ? "\r\x1b[K" : "") << kToolName << ": error: " << subject << ": " << detail << "\n";
    line.print();
}

[[noreturn]] void endProcess(std::string_view subject, std::string_view detail) {
    if (isEnding.exchange(true)) {
        if (isEndedHere) ::_exit(kInternalCode);
        for (;;) ::pause();  // another thread ends the process
    }
    isEndedHere = true;
    formats::stopOutputs();
    formats::abandonTemporaries();
    printError(subject, detail);
    ::_exit(kInternalCode);
}

[[noreturn]] void endUncaught() {
    const std::type_info* const type = abi::__cxa_current_exception_type();
    const auto is = [type](const std::type_info& other) { return type != nullptr && *type == other; };
    if (is(typeid(std::bad_alloc)) || is(typeid(std::bad_array_new_length)) || is(typeid(std::length_error))) endOutOfMemory();
    endProcess(kToolName, "found an internal error that nothing caught, expected none");
}

}  // namespace

void endOutOfMemory() {
    endProcess(kMemorySubject, kTooLittleMemory);
}

void installLastResort() {
    std::set_terminate(endUncaught);
}

void setLastResortLog(LogFormat log) {
    logFormat = log;
}

}  // namespace lightcook::pipeline
