// Counts how often a file is opened, by this process or another.
#pragma once

#include <sys/inotify.h>
#include <unistd.h>

#include <filesystem>

namespace lightcook::formats {

class Opens {
public:
    /// Counts from here on.
    explicit Opens(const std::filesystem::path& file) : queue_(inotify_init1(IN_NONBLOCK)) {
        inotify_add_watch(queue_, file.c_str(), IN_OPEN | IN_CLOSE);  // both, since events that are alike become one
    }
    ~Opens() { close(queue_); }
    Opens(const Opens&) = delete;
    Opens& operator=(const Opens&) = delete;

    /// Returns the number since the construction or the last call.
    int count() const {
        int opens = 0;
        inotify_event event{};  // those of a file have no name
        while (read(queue_, &event, sizeof(event)) == sizeof(event)) opens += (event.mask & IN_OPEN) != 0 ? 1 : 0;
        return opens;
    }

private:
    int queue_;
};

}  // namespace lightcook::formats
