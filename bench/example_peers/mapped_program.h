// Functions of a program, called from another process image: for encoders that are shipped as programs alone.
#pragma once

#include <string>

namespace lightcook::bench {

/// A program of x86-64 Linux that is linked for fixed addresses (ET_EXEC), mapped into this process at these addresses. Its `main` and
/// its constructors do not run, so call only functions that need neither. It stays mapped until the process ends.
class MappedProgram {
public:
    /// Maps a program. The libraries that it needs must be installed; this process must be position-independent.
    /// Throws std::runtime_error with one line that says what is wrong.
    explicit MappedProgram(const std::string& file);

    /// Returns the function of a symbol's name, as `nm` prints it. Throws std::runtime_error if the program has none.
    template <class Function>
    Function* function(const std::string& symbol) const {
        return reinterpret_cast<Function*>(addressOf(symbol));
    }

private:
    [[nodiscard]] void* addressOf(const std::string& symbol) const;

    std::string file_;
    std::string bytes_;  ///< of the file: its table of symbols
};

}  // namespace lightcook::bench
