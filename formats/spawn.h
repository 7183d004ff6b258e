// Programs that this process starts.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <utility>
#include <vector>

namespace lightcook::formats {

/// The descriptors of a program that is started. Steps are taken in their order; a fault of one shows when the program starts.
class SpawnFiles {
public:
    SpawnFiles() { ::posix_spawn_file_actions_init(&actions_); }
    ~SpawnFiles() { ::posix_spawn_file_actions_destroy(&actions_); }
    SpawnFiles(const SpawnFiles&) = delete;
    SpawnFiles& operator=(const SpawnFiles&) = delete;
    void give(int descriptor, int number) { ::posix_spawn_file_actions_adddup2(&actions_, descriptor, number); }
    void giveNothing(int number) { ::posix_spawn_file_actions_addopen(&actions_, number, "/dev/null", O_RDWR, 0); }
    const posix_spawn_file_actions_t& actions() const { return actions_; }

private:
    posix_spawn_file_actions_t actions_{};
};

/// Starts a program in a process group of its own: signals of a terminal are for this process to answer. The program handles signals as a
/// new one does, whatever this process blocks or ignores.
/// words  the name that the program gets, and its arguments
/// Returns the process, or 0 and the number of the error.
inline std::pair<pid_t, int> spawn(const std::string& program, std::vector<std::string> words, const SpawnFiles& files) {
    posix_spawnattr_t attributes;
    ::posix_spawnattr_init(&attributes);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    ::posix_spawnattr_setsigdefault(&attributes, &all);
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_t process = 0;
    const int fault = ::posix_spawn(&process, program.c_str(), &files.actions(), &attributes, arguments.data(), environ);
    ::posix_spawnattr_destroy(&attributes);
    return {fault == 0 ? process : 0, fault};
}

}  // namespace lightcook::formats
