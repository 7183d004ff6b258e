// Faults of our own code, all in one build (mutant schemata: Untch, Offutt and Harrold, ISSTA 1993). seed.py rewrites sources with what
// stands here:
//   0.5f          (lightcook::mutants::is(7) ? 1.0f : 0.5f)
//   a + b         a + PlusIsMinus<7>{} + b: the operator binds as before, so that nobody has to find where a and b begin and end
//   std::min(     LIGHTCOOK_MUTANT_CALL(7, std::min, std::max)(
// LIGHTCOOK_MUTANT=7 selects fault 7. LIGHTCOOK_MUTANTS_REACHED=FILE: at its end the program writes there which of them have run. Two kinds
// never run, and keep what is written: constant expressions, and operators whose replacement gives a value of another type.
#pragma once

#include <type_traits>

namespace lightcook::mutants {

extern const int kSelected;
extern unsigned char reached[];

constexpr bool is(int number) {
    if (std::is_constant_evaluated()) return false;
    reached[number] = 1;
    return number == kSelected;
}

/// Numbers are copied, so that a lambda may use a constant without a capture. Others are referred to, as expressions of Eigen do.
template <class T>
concept Number = std::is_arithmetic_v<std::remove_reference_t<T>> || std::is_enum_v<std::remove_reference_t<T>>;
template <class T>
concept NoNumber = !Number<T>;
template <class T>
using Operand = std::conditional_t<Number<T>, T, T&>;

// NOLINTBEGIN(bugprone-macro-parentheses): the arguments are names and operators
#define LIGHTCOOK_MUTANT_OPERATOR(Name, op, other)                                                        \
    template <int kNumber>                                                                                \
    struct Name {};                                                                                       \
    template <class A, int kNumber>                                                                       \
    struct Name##Left {                                                                                   \
        Operand<A> a;                                                                                     \
        template <class B>                                                                                \
        constexpr auto with(B& b) const {                                                                 \
            if constexpr (requires { requires std::is_same_v<decltype(a op b), decltype(a other b)>; }) { \
                if (is(kNumber)) return a other b;                                                        \
            }                                                                                             \
            return a op b;                                                                                \
        }                                                                                                 \
    };                                                                                                    \
    template <Number A, int kNumber>                                                                      \
    constexpr Name##Left<A, kNumber> operator op(A a, Name<kNumber>) {                                    \
        return {a};                                                                                       \
    }                                                                                                     \
    template <NoNumber A, int kNumber>                                                                    \
    constexpr Name##Left<std::remove_reference_t<A>, kNumber> operator op(A&& a, Name<kNumber>) {         \
        return {a};                                                                                       \
    }                                                                                                     \
    template <class A, int kNumber, Number B>                                                             \
    constexpr auto operator op(const Name##Left<A, kNumber>& left, B b) {                                 \
        return left.with(b);                                                                              \
    }                                                                                                     \
    template <class A, int kNumber, NoNumber B>                                                           \
    constexpr auto operator op(const Name##Left<A, kNumber>& left, B&& b) {                               \
        return left.with(b);                                                                              \
    }
// NOLINTEND(bugprone-macro-parentheses)
LIGHTCOOK_MUTANT_OPERATOR(PlusIsMinus, +, -)
LIGHTCOOK_MUTANT_OPERATOR(MinusIsPlus, -, +)
LIGHTCOOK_MUTANT_OPERATOR(TimesIsOver, *, /)
LIGHTCOOK_MUTANT_OPERATOR(OverIsTimes, /, *)
LIGHTCOOK_MUTANT_OPERATOR(LessIsLessEqual, <, <=)
LIGHTCOOK_MUTANT_OPERATOR(LessIsGreater, <, >)
LIGHTCOOK_MUTANT_OPERATOR(GreaterIsGreaterEqual, >, >=)
LIGHTCOOK_MUTANT_OPERATOR(GreaterIsLess, >, <)
LIGHTCOOK_MUTANT_OPERATOR(LessEqualIsLess, <=, <)
LIGHTCOOK_MUTANT_OPERATOR(LessEqualIsGreaterEqual, <=, >=)
LIGHTCOOK_MUTANT_OPERATOR(GreaterEqualIsGreater, >=, >)
LIGHTCOOK_MUTANT_OPERATOR(GreaterEqualIsLessEqual, >=, <=)
LIGHTCOOK_MUTANT_OPERATOR(EqualIsUnequal, ==, !=)
LIGHTCOOK_MUTANT_OPERATOR(UnequalIsEqual, !=, ==)
#undef LIGHTCOOK_MUTANT_OPERATOR

/// Changes a named constant, or the element of a table, that is a number.
template <int kNumber, Number T>
constexpr T changed(T value) {
    if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
        if (is(kNumber)) return std::is_floating_point_v<T> ? static_cast<T>(value * 1.25f) : static_cast<T>(value + 1);
    }
    return value;
}
template <int kNumber, NoNumber T>
constexpr const T& changed(const T& value) {
    return value;
}

}  // namespace lightcook::mutants

/// A function that calls `function`, or `other` with fault `number`.
#define LIGHTCOOK_MUTANT_CALL(number, function, other)                                  \
    [](auto... given) constexpr {                                                       \
        return ::lightcook::mutants::is(number) ? other(given...) : function(given...); \
    }
