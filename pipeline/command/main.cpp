// Start-up: standard streams, threads, and the last resort for exceptions. The commands are in command.cpp.
#include <fcntl.h>
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <stdexcept>
#include <system_error>

#include "compress/encode_options.h"
#include "formats/foreign_files.h"
#include "formats/process.h"
#include "pipeline/command/command.h"
#include "pipeline/command/last_resort.h"
#include "pipeline/command/session.h"
#include "pipeline/graph/version.h"
#include "pipeline/report/exit_codes.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;

/// Reports a standard output that cannot be written, such as a full disk. Returns the exit code then, or that of the command.
int finishStandardOutput(int code, LogFormat log) {
    if (!Terminal::hasLostOutput()) return code;
    Terminal(log).error({ErrorCode::Internal, "standard output", "found a write that failed, expected room for all that is printed"});
    return code != 0 ? code : exitCode(ErrorCode::Internal);
}

/// Runs a command on its own number of threads.
int runCommand(const CommandFunction& command, const GlobalOptions& global) {
    if (global.instructions == "avx2") compress::allowInstructionSet(compress::InstructionSet::Avx2);
    const int threads = global.threadCount();
    const tbb::global_control parallelism(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    // An arena of its own: the default one has no more slots than the machine has cores, whatever -j says.
    tbb::task_arena arena(threads);
    try {
        return arena.execute([&] {
            Session session(global);
            const int code = command(session);
            // Also where the command returned 0, because its outputs were complete before the signal.
            return session.state.interrupted ? session.exitCodeOfSignal() : finishStandardOutput(code, global.logFormat());
        });
    } catch (const std::bad_alloc&) {
        endOutOfMemory();  // here, since the destructors of oneTBB wait for ever after it threw this
    }
}

int run(int argc, char** argv) {
    GlobalOptions global;
    ParsedCommandLine parsed;
    const auto fail = [&](const std::string& subject, const std::string& detail) {
        Terminal terminal(global.logFormat());
        const formats::Error error{ErrorCode::Internal, subject, detail};
        terminal.error(error);
        parsed.documents.write({error}, terminal);
        return exitCode(ErrorCode::Internal);
    };
    try {
        parsed = parseCommandLine(argc, argv, global);
        setLastResortLog(global.logFormat());
        if (!parsed.function) return finishStandardOutput(parsed.exitCode, global.logFormat());
        if (!global.noSandbox) {
            const auto folder = formats::programFolder();
            if (!folder) return fail(folder.error().subject, folder.error().detail);
            formats::readInChildProcesses({.program = *folder / "lightcook-read"});
        }
        return runCommand(parsed.function, global);
    } catch (const std::system_error& fault) {
        if (fault.code() == std::errc::resource_unavailable_try_again)
            return fail("threads", "found no room for another one, expected more: use fewer (-j N), or raise the limit (ulimit -u)");
        return fail("the operating system", fmt::format("found the error '{}', expected success", fault.what()));
    } catch (const std::bad_alloc&) {
        endOutOfMemory();
    } catch (const std::length_error&) {  // more than any memory holds
        return fail(kMemorySubject, kTooLittleMemory);
    } catch (const std::exception& fault) {
        return fail(kToolName, fmt::format("found an internal error ({}), expected none", fault.what()));
    }
}

/// Opens /dev/null for every standard stream that is closed. Otherwise the next file that is opened would get the stream's number, and
/// messages would be written into it.
void openStandardStreams() {
    for (int descriptor = ::open("/dev/null", O_RDWR); descriptor >= 0; descriptor = ::open("/dev/null", O_RDWR))
        if (descriptor > STDERR_FILENO) {
            ::close(descriptor);
            break;
        }
}

/// Before the other initializers of the program, which may run out of memory too.
struct LastResort {
    LastResort() { installLastResort(); }
};
[[gnu::init_priority(101)]] const LastResort kLastResort;

}  // namespace
}  // namespace lightcook::pipeline

int main(int argc, char** argv) {
    lightcook::pipeline::openStandardStreams();
    return lightcook::pipeline::run(argc, argv);  // what it throws goes to the last resort
}
