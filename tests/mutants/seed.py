#!/usr/bin/env python3
"""Puts faults into a copy of our sources: seed.py ROOT OUTPUT COUNT SEED

OUTPUT gets the sources of compress/, verify/ and shaders/ (not the headers at the root of a module, which other modules include) with COUNT
faults in terms of mutants.h, `mutants.cpp`, and `mutants.json`, a list of {"number", "group", "kind", "file", "line", "was", "is"}. A
fault changes one operator, constant or call; which one is chosen at run time. Places are drawn with SEED, from each group in turn. Numbers
are 0 to COUNT - 1, in the order drawn.
"""
import json
import pathlib
import random
import re
import sys

GROUPS = {  # name: folder below ROOT
    "bc1": "compress/bc1", "bc4": "compress/bc4", "bc6h": "compress/bc6h", "bc7": "compress/bc7", "blocks": "compress/block",
    "texels": "compress/texel", "light map": "compress/light_map", "basis": "compress/light_map/basis",
    "decoders": "verify/texture", "shading": "verify/light_map", "figures": "verify/error", "other assets": "verify/assets",
    "shader": "shaders",
}
COPIED = {"compress": {".cpp", ".h"}, "verify": {".cpp", ".h"}, "shaders": {".glsl"}}

TOKEN = re.compile(r"""
    (?P<skip>//[^\n]*|/\*.*?\*/|\s+|^[ \t]*\#(?:\\\n|[^\n])*)
  | (?P<text>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])')
  | (?P<name>[A-Za-z_]\w*(?:::[A-Za-z_]\w*)*)
  | (?P<number>0[bB][01']+[uUlL]*|0[xX][0-9a-fA-F'.]+(?:[pP][+-]?\d+[fF]?|[uUlL]*)|(?:\d[\d']*\.?[\d']*|\.\d+)(?:[eE][+-]?\d+)?[fFuUlLzZ]*)
  | (?P<sign><<=|>>=|<=>|->|\+\+|--|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|::|.)
""", re.X | re.S | re.M)

NO_OPERANDS = {"return", "template", "operator", "case", "else", "typename", "class", "throw", "new", "delete", "sizeof", "in", "const",
               "requires", "concept"}
OPERATORS = {
    "+": [("PlusIsMinus", "-")], "-": [("MinusIsPlus", "+")], "*": [("TimesIsOver", "/")], "/": [("OverIsTimes", "*")],
    "<": [("LessIsLessEqual", "<="), ("LessIsGreater", ">")], ">": [("GreaterIsGreaterEqual", ">="), ("GreaterIsLess", "<")],
    "<=": [("LessEqualIsLess", "<"), ("LessEqualIsGreaterEqual", ">=")],
    ">=": [("GreaterEqualIsGreater", ">"), ("GreaterEqualIsLessEqual", "<=")],
    "==": [("EqualIsUnequal", "!=")], "!=": [("UnequalIsEqual", "==")],
}
CALLS = {"std::min": "std::max", "std::max": "std::min", "hn::Min": "hn::Max", "hn::Max": "hn::Min", "std::floor": "std::ceil",
         "std::ceil": "std::floor", "hn::Floor": "hn::Round", "hn::Round": "hn::Floor", "hn::MulAdd": "hn::NegMulAdd",
         "hn::NegMulAdd": "hn::MulAdd", "hn::Or": "hn::And", "hn::And": "hn::Or", "hn::AndNot": "hn::And"}
SHADER_CALLS = {"min": "max", "max": "min"}


def tokens_of(text):
    """[kind, text, start, innermost open bracket]"""
    found, open_ = [], []
    for match in TOKEN.finditer(text):
        if match.lastgroup == "skip":
            continue
        token = match.group()
        if token in ")]}" and open_:
            open_.pop()
        found.append((match.lastgroup, token, match.start(), open_[-1] if open_ else ""))
        if token in "([{":
            open_.append(token)
    return found


def changed_number(token, rng):
    """A literal of the same type and another value."""
    if re.search("[pP]", token) and token[:2] in ("0x", "0X"):
        return f"(2 * {token})"
    digits = re.match(r"0[bB][01']+|0[xX][0-9a-fA-F']+|[\d.']+(?:[eE][+-]?\d+)?", token).group()
    suffix = token[len(digits):]
    plain = digits.replace("'", "")
    if plain[:2] in ("0b", "0B"):
        return bin(int(plain, 2) + 1) + suffix
    if plain[:2] in ("0x", "0X"):
        return hex(int(plain, 16) + 1) + suffix
    if re.search(r"[.eE]", plain) or suffix in ("f", "F"):
        value = float(plain)
        if value == 0:
            return rng.choice(["1.0", "-1.0"]) + suffix
        return repr(rng.choice([-value, 1.25 * value, 0.5 * value])) + suffix
    value = int(plain, 10)
    return str(value + rng.choice([-1, 1] if value > 0 else [1])) + suffix


def places_of(text, is_shader):
    """[kind, start, end, function(number, rng) -> (text in place, what it is then)]"""
    tokens = tokens_of(text)
    for at, (kind, token, start, bracket) in enumerate(tokens):
        before = tokens[at - 1] if at else ("sign", "", 0, "")
        after = tokens[at + 1] if at + 1 < len(tokens) else ("sign", "", 0, "")
        end = start + len(token)
        is_in_list = bracket == "{" and before[1] in "{,"
        is_spaced = text[start - 1].isspace() and text[end:end + 1].isspace()
        if token in OPERATORS and is_spaced and (
                before[0] == "number" or before[0] == "name" and before[1] not in NO_OPERANDS or before[1] in (")", "]")):
            def operator(number, rng, token=token):
                name, other = rng.choice(OPERATORS[token])
                return f"{token} ::lightcook::mutants::{name}<{number}>{{}} {token}", other
            yield "operator", start, end, operator
        elif kind == "number" and not is_in_list and not (token == "0" and before[1] == "=") and before[1] != "case":
            def number_(number, rng, token=token):
                other = changed_number(token, rng)
                return f"(::lightcook::mutants::is({number}) ? {other} : {token})", other
            yield "constant", start, end, number_
        elif re.fullmatch(r"k[A-Z]\w*", token) and not is_in_list and after[1] not in ("(", "::", ".", "{", "<", "=", ">") and (
                before[0] == "sign" and before[1] not in ("::", ".", "->", "]", ")", "&", "~", "}", ">", "<", ";")
                or before[1] == "return" or before[1] in "<>" and text[before[2] + 1].isspace() and text[before[2] - 1].isspace()):
            if after[1] == "[":  # the element of a table
                depth, close = 0, at + 1
                while close < len(tokens):
                    depth += {"[": 1, "]": -1}.get(tokens[close][1], 0)
                    if depth == 0:
                        break
                    close += 1
                end = tokens[close][2] + 1

            def named(number, rng, what=text[start:end]):
                return f"::lightcook::mutants::changed<{number}>({what})", "x 1.25 or + 1"
            yield "constant", start, end, named
        elif kind == "name" and after[1] == "(" and tokens[at + 2][1] != "{" and token in (SHADER_CALLS if is_shader else CALLS):
            def call(number, rng, token=token):
                other = (SHADER_CALLS if is_shader else CALLS)[token]
                return f"LIGHTCOOK_MUTANT_CALL({number}, {token}, {other})", other
            yield "call", start, end, call


def main():
    root, output, count, seed = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
    texts, drawn = {}, {name: [] for name in GROUPS}
    for module, suffixes in COPIED.items():
        for file in sorted((root / module).rglob("*")):
            name = file.relative_to(root).as_posix()
            if file.suffix not in suffixes or (file.parent == root / module and file.suffix == ".h"):
                continue
            texts[name] = file.read_text()
            group = max((g for g, folder in GROUPS.items() if name.startswith(folder + "/")), key=lambda g: len(GROUPS[g]))
            drawn[group] += [(name, *place) for place in places_of(texts[name], file.suffix == ".glsl")]
    rng = random.Random(seed)
    for places in drawn.values():
        rng.shuffle(places)
    faults, edits = [], {}
    for turn in range(count):
        for group, places in drawn.items():
            if turn >= len(places) or len(faults) == count:
                continue
            name, kind, start, end, change = places[turn]
            if any(start < e and s < end for s, e, _ in edits.get(name, [])):
                continue  # inside of another
            text, other = change(len(faults), rng)
            edits.setdefault(name, []).append((start, end, text))
            faults.append({"number": len(faults), "group": group, "kind": kind, "file": name,
                           "line": texts[name].count("\n", 0, start) + 1, "was": texts[name][start:end], "is": other})
    for name, text in texts.items():
        for start, end, change in sorted(edits.get(name, []), reverse=True):
            text = text[:start] + change + text[end:]
        target = output / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists() or target.read_text() != text:
            target.write_text(text)
    (output / "mutants.json").write_text(json.dumps(faults, indent=1))
    print({name: len(places) for name, places in drawn.items()})


if __name__ == "__main__":
    main()
