#include "pipeline/command/terminal/mistake.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "formats/nearest.h"
#include "pipeline/command/command.h"
#include "pipeline/command/reference/program_doc.h"
#include "pipeline/command/session.h"

namespace lightcook::pipeline {
namespace {

enum class ParseResult { Fine, Unknown, BadValue, TooFew, TooMany, Excluded, Other };

struct Attempt {
    ParseResult result = ParseResult::Fine;
    std::string message;
};

void requireNothing(CLI::App& app) {
    app.require_subcommand(0, 1);  // a file may have the name of a command
    for (CLI::Option* option : app.get_options()) option->required(false);
    for (CLI::App* sub : app.get_subcommands(nullptr)) requireNothing(*sub);
}

/// Parses some arguments with nothing required.
Attempt attempt(std::span<const std::string> arguments) {
    CLI::App app;
    GlobalOptions global;
    CommandFunction selected;
    defineProgram(app, global, selected);
    requireNothing(app);
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
    try {
        app.parse(std::move(reversed));
    } catch (const CLI::ExtrasError& mistake) {
        return {ParseResult::Unknown, mistake.what()};
    } catch (const CLI::ArgumentMismatch& mistake) {
        const std::string message = mistake.what();
        return {message.find(": At Most ") == std::string::npos ? ParseResult::TooFew : ParseResult::TooMany, message};
    } catch (const CLI::ValidationError& mistake) {
        return {ParseResult::BadValue, mistake.what()};
    } catch (const CLI::ConversionError& mistake) {
        return {ParseResult::BadValue, mistake.what()};
    } catch (const CLI::RequiresError&) {
        return {};  // the other option may follow
    } catch (const CLI::ExcludesError& mistake) {
        return {ParseResult::Excluded, mistake.what()};
    } catch (const CLI::CallForHelp&) {
        return {};
    } catch (const CLI::CallForVersion&) {
        return {};
    } catch (const CLI::ParseError& mistake) {
        return {ParseResult::Other, mistake.what()};
    }
    return {};
}

formats::Error refused(std::string subject, std::string detail) {
    return {formats::ErrorCode::InvalidRequest, std::move(subject), std::move(detail)};
}

bool isOption(const std::string& argument) {
    return argument.size() > 1 && argument[0] == '-' && (argument[1] < '0' || argument[1] > '9') && argument[1] != '.';
}

/// The command of some arguments, and the options that it takes.
class Syntax {
public:
    explicit Syntax(std::span<const std::string> arguments) : program_(describeProgram()) {
        for (std::size_t i = 0; i < arguments.size() && command_ == nullptr; ++i) {
            if (isOption(arguments[i])) {
                const Word word = split(program_.options, arguments[i]);
                if (word.option != nullptr && word.option->value != OptionDoc::Value::None && !word.value) ++i;
                continue;
            }
            for (const CommandDoc& command : program_.commands)
                if (command.name == arguments[i]) command_ = &command;
        }
        if (command_ != nullptr) all_ = command_->options;
        all_.insert(all_.end(), program_.options.begin(), program_.options.end());
    }

    const CommandDoc* command() const { return command_; }

    /// An argument that begins with an option: "--effort=11", "-j8", "-qj".
    struct Word {
        const OptionDoc* option = nullptr;  ///< null: unknown
        std::string name;                   ///< as typed: "--effort"; of several flags in one word the last option
        std::optional<std::string> value;   ///< that is part of the argument
    };
    Word word(const std::string& argument) const { return split(all_, argument); }
    const OptionDoc* option(const std::string& argument) const { return word(argument).option; }

    const OptionDoc* positional(const std::string& name) const {
        if (command_ == nullptr) return nullptr;
        for (const OptionDoc& each : command_->options)
            if (each.isPositional && each.names.front() == name) return &each;
        return nullptr;
    }

    std::vector<std::string> optionNames() const {
        std::vector<std::string> names;
        const auto add = [&](const std::vector<OptionDoc>& options) {
            for (const OptionDoc& each : options)
                if (!each.isPositional) names.insert(names.end(), each.names.begin(), each.names.end());
        };
        if (command_ != nullptr) add(command_->options);
        add(program_.options);
        return names;
    }

    std::vector<std::string> commandNames() const {
        std::vector<std::string> names;
        for (const CommandDoc& each : program_.commands) names.push_back(each.name);
        return names;
    }

private:
    static const OptionDoc* find(const std::vector<OptionDoc>& options, const std::string& name) {
        for (const OptionDoc& each : options)
            if (!each.isPositional && std::ranges::find(each.names, name) != each.names.end()) return &each;
        return nullptr;
    }

    static Word split(const std::vector<OptionDoc>& options, const std::string& argument) {
        if (argument.starts_with("--")) {
            const std::size_t sign = argument.find('=');
            Word word{nullptr, argument.substr(0, sign), std::nullopt};
            word.option = find(options, word.name);
            if (sign != std::string::npos) word.value = argument.substr(sign + 1);
            return word;
        }
        // One letter each; what follows the first one that takes a value is that value.
        Word word;
        for (std::size_t i = 1; i < argument.size(); ++i) {
            word = {nullptr, std::string("-") + argument[i], std::nullopt};
            word.option = find(options, word.name);
            if (word.option == nullptr) return {nullptr, argument.substr(0, argument.find('=')), std::nullopt};
            if (word.option->value == OptionDoc::Value::None) continue;
            if (i + 1 < argument.size()) word.value = argument.substr(i + 1);
            break;
        }
        return word;
    }

    ProgramDoc program_;
    const CommandDoc* command_ = nullptr;
    std::vector<OptionDoc> all_;  ///< of the command and of the program
};

formats::Error unknownArgument(const Syntax& syntax, const std::string& argument) {
    const std::string name = argument.substr(0, argument.find('='));
    if (isOption(argument)) {
        const std::string of = syntax.command() != nullptr ? " of " + syntax.command()->name : "";
        return refused("command line", fmt::format("found the unknown option '{}', expected an option{}{}", name, of,
                                                   formats::nearestHint(name, syntax.optionNames())));
    }
    if (syntax.command() == nullptr)
        return refused("command line",
                       fmt::format("found the unknown command '{}', expected one of: {}{}", argument,
                                   fmt::join(syntax.commandNames(), ", "), formats::nearestHint(argument, syntax.commandNames())));
    return refused("command line", fmt::format("found '{}' after everything that {} takes, expected `lightcook {}`", argument,
                                               syntax.command()->name, syntax.command()->usage()));
}

/// Returns the option that the last argument is a value of: "--effort" of "--effort 11" and of "--effort=11".
std::string optionOfLast(const Syntax& syntax, std::span<const std::string> arguments) {
    for (std::size_t i = arguments.size(); i-- > 0;)
        if (isOption(arguments[i]))
            if (const Syntax::Word word = syntax.word(arguments[i]); word.option != nullptr) return word.name;
    return "command line";
}

/// Returns true for a whole number that is larger than any option takes.
bool isTooLarge(const std::string& value) {
    int number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    return error == std::errc::result_out_of_range && end == value.data() + value.size() && !value.starts_with('-');
}

std::string expectedValue(const OptionDoc& option, const std::string& found) {
    if (option.meaning.starts_with("a whole number") && isTooLarge(found))
        return fmt::format("{}, at most {}", option.meaning, std::numeric_limits<int>::max());
    if (option.choices.empty()) return option.meaning.empty() ? option.placeholder : option.meaning;
    return fmt::format("one of: {}{}", fmt::join(option.choices, ", "), formats::nearestHint(found, option.choices));
}

formats::Error badValue(const Syntax& syntax, std::span<const std::string> arguments, const std::string& message) {
    const std::string name = optionOfLast(syntax, arguments);
    if (const std::size_t found = message.find("found '"); found != std::string::npos) return refused(name, message.substr(found));
    const OptionDoc* option = syntax.option(name);
    std::string value = arguments.back();
    if (isOption(value)) value = syntax.word(value).value.value_or(value);
    if (option == nullptr) return refused(name, fmt::format("found '{}' ({}), expected what --help shows", value, message));
    return refused(name, fmt::format("found '{}', expected {}", value, expectedValue(*option, value)));
}

/// Returns the error of an option without its value, or without all of them.
formats::Error tooFewValues(const Syntax& syntax, std::span<const std::string> arguments) {
    const std::string name = optionOfLast(syntax, arguments);
    const OptionDoc* option = syntax.option(name);
    const std::string expected = option != nullptr ? expectedValue(*option, "") : "a value";
    const bool hasSome = !isOption(arguments.back()) || !syntax.word(arguments.back()).value.value_or("").empty();
    return refused(name, fmt::format("found {}, expected {}", hasSome ? "too few values" : "no value", expected));
}

/// Returns the error of an option that was given twice, or with more values than it takes.
formats::Error tooManyValues(const Syntax& syntax, std::span<const std::string> arguments, const std::string& message) {
    const std::string name = optionOfLast(syntax, arguments);
    const OptionDoc* option = syntax.option(name);
    const auto isIt = [&](const std::string& argument) { return isOption(argument) && syntax.option(argument) == option; };
    if (option == nullptr) return refused(name, fmt::format("found too many values ({}), expected what --help shows", message));
    if (const auto count = std::ranges::count_if(arguments, isIt); count > 1)
        return refused(name, fmt::format("found this option {} times, expected it once", count));
    const std::string values = message.substr(message.rfind(' ') + 1);  // "--m: At Most 2 required but received 3"
    return refused(name, fmt::format("found {} values, expected {}", values, expectedValue(*option, "")));
}

/// Returns the options before and after a word of CLI11's message: "--fail-over" and "--baseline" of "--fail-over requires --baseline".
std::optional<std::pair<std::string, std::string>> optionsAround(const std::string& message, const std::string& word) {
    const std::size_t at = message.find(word);
    if (at == std::string::npos || !isOption(message)) return std::nullopt;
    return std::pair(message.substr(0, at), message.substr(at + word.size()));
}

/// Returns the error of two options of which a command takes only one.
formats::Error excluded(const std::string& message) {
    const auto options = optionsAround(message, " excludes ");
    if (!options) return refused("command line", fmt::format("found a mistake ({}), expected what --help shows", message));
    return refused(options->first, fmt::format("found {} beside it, expected one of them", options->second));
}

/// Returns the error of something that is missing from a command line without other mistakes.
formats::Error missing(const Syntax& syntax, const std::string& message) {
    if (syntax.command() == nullptr)
        return refused("command line", fmt::format("found no command, expected one of: {}", fmt::join(syntax.commandNames(), ", ")));
    const std::string name = message.substr(0, message.find(' '));
    if (const OptionDoc* positional = syntax.positional(name))
        return refused("command line",
                       fmt::format("found no {}, expected `lightcook {}`: {}", name, syntax.command()->usage(), positional->description));
    if (const auto options = optionsAround(message, " requires "))
        return refused(options->first, fmt::format("found no {}, expected it beside this option", options->second));
    if (const auto option = optionsAround(message, " is required")) {
        const OptionDoc* const known = syntax.option(option->first);
        return refused("command line", fmt::format("found no {}, expected `lightcook {}`{}", option->first, syntax.command()->usage(),
                                                   known != nullptr ? ": " + known->description : ""));
    }
    return refused("command line", fmt::format("found a mistake ({}), expected `lightcook {}`", message, syntax.command()->usage()));
}

}  // namespace

formats::Error firstMistake(std::span<const std::string> arguments, const std::string& message) {
    bool isWaiting = false;  // for the value of the option before
    for (std::size_t count = 1; count <= arguments.size(); ++count) {
        const auto part = arguments.first(count);
        const Syntax syntax(part);
        const Attempt tried = attempt(part);
        if (isWaiting && isOption(part.back()) && tried.result != ParseResult::Fine)
            return tooFewValues(syntax, arguments.first(count - 1));
        isWaiting = tried.result == ParseResult::TooFew;
        if (tried.result == ParseResult::Unknown) return unknownArgument(syntax, part.back());
        if (tried.result == ParseResult::BadValue) return badValue(syntax, part, tried.message);
        if (tried.result == ParseResult::TooMany) return tooManyValues(syntax, part, tried.message);
        if (tried.result == ParseResult::Excluded) return excluded(tried.message);
        if (tried.result == ParseResult::Other)
            return refused("command line", fmt::format("found a mistake ({}), expected what --help shows", tried.message));
    }
    if (isWaiting) return tooFewValues(Syntax(arguments), arguments);
    return missing(Syntax(arguments), message);
}

}  // namespace lightcook::pipeline
