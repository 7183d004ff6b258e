// Start-up: standard streams, threads, and the last resort for exceptions. The commands are in command.cpp.
#include <fcntl.h>
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <new>
#include <system_error>

#include "compress/encode_options.h"
#include "pipeline/command/command.h"
#include "pipeline/command/session.h"
#include "pipeline/graph/version.h"
#include "pipeline/report/exit_codes.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;

/// Reports a standard output that cannot be written, such as a full disk. Returns the exit code then, or that of the command.
int finishStandardOutput(int code, LogFormat log) {
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
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
    return arena.execute([&] {
        Session session(global);
        const int code = command(session);
        // Also where the command returned 0, because its outputs were complete before the signal.
        return session.state.interrupted ? session.exitCodeOfSignal() : finishStandardOutput(code, global.logFormat());
    });
}

int run(int argc, char** argv) {
    GlobalOptions global;
    const ParsedCommandLine parsed = parseCommandLine(argc, argv, global);
    if (!parsed.function) return finishStandardOutput(parsed.exitCode, global.logFormat());
    const auto fail = [&](const std::string& subject, const std::string& detail) {
        Terminal terminal(global.logFormat());
        const formats::Error error{ErrorCode::Internal, subject, detail};
        terminal.error(error);
        parsed.documents.write({error}, terminal);
        return exitCode(ErrorCode::Internal);
    };
    try {
        return runCommand(parsed.function, global);
    } catch (const std::system_error& fault) {
        return fail("the operating system", fmt::format("found the error '{}', expected success", fault.what()));
    } catch (const std::bad_alloc&) {
        return fail("memory", "found too little of it, expected more: free some, or use fewer threads (-j N)");
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

}  // namespace
}  // namespace lightcook::pipeline

int main(int argc, char** argv) {
    lightcook::pipeline::openStandardStreams();
    return lightcook::pipeline::run(argc, argv);
}
