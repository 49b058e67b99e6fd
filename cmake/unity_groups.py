#!/usr/bin/python3
"""Which sources may be compiled as one: unity_groups.py MAX SOURCE...; prints for each source the number of its group.

In one group no two sources have the same name for themselves (in an anonymous namespace, or a macro), and none calls what
another one has for itself: nothing clashes, and no call means another function than in a build without groups. The same alias
in two sources (namespace fs = std::filesystem) is none of these names. A source that must be compiled by itself has the group
"alone".
"""

import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scripts"))
sys.dont_write_bytecode = True
from check_functions import Parser  # noqa: E402 (the same reading of C++)

# Macros that look like functions; what they declare has a name of its own.
MACROS = {"TEST", "TEST_F", "TEST_P", "TYPED_TEST", "TYPED_TEST_SUITE", "INSTANTIATE_TEST_SUITE_P"}
WORD = re.compile(r"[A-Za-z_]\w*$")


def own_names(text, parser):
    """The names that a source has for itself, and for each of its aliases what it stands for."""
    aliases = {}
    names = set(re.findall(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", text, re.M))

    def declaration(start, end):
        """Names that the declaration in front of a body, an initializer or a semicolon introduces."""
        k, depth_end = start, end
        if parser.at(k) in ("using", "namespace") and parser.at(k + 2) == "=":
            aliases[parser.at(k + 1)] = " ".join(parser.at(i) for i in range(k + 3, end))
            return set()
        if parser.at(k) in ("namespace", "using", "template") and parser.at(k) != "template":
            return set()
        found, last = set(), ""
        while k < depth_end:
            token = parser.at(k)
            if token == "<":  # parameters or arguments of a template
                depth = 0
                while k < depth_end:
                    depth += {"<": 1, ">": -1}.get(parser.at(k), 0)
                    k += 1
                    if depth == 0:
                        break
                continue
            if token in ("struct", "class", "enum", "union"):
                following = [parser.at(j) for j in range(k + 1, depth_end) if WORD.match(parser.at(j)) and
                             parser.at(j) not in ("class", "final", "alignas", "__attribute__")]
                return found | set(following[:1])
            if token == "(":
                return found | {last} if last else found
            if token in ("=", "[", ","):
                found |= {last} if last else set()
                if token == "=":  # to the next comma outside of brackets
                    while k < depth_end and parser.at(k) != ",":
                        k = parser.past(k) if parser.at(k) in ("(", "[", "{") else k + 1
                    continue
            if token == "[[":
                k = parser.past(k)
                continue
            if WORD.match(token):
                last = token
            k = parser.past(k) if token in ("[", "{") else k + 1
        return found | ({last} if last else set())

    def level(i, end):
        start = i
        while i < end:
            token = parser.at(i)
            if token == ";":
                names.update(declaration(start, i))
                start = i = i + 1
            elif token == "{":
                after = parser.past(i)
                if parser.at(after) not in (";", ",") or parser.at(start) in ("struct", "class", "enum", "union"):
                    names.update(declaration(start, i))
                    start = after + (parser.at(after) == ";")
                    i = start
                else:
                    i = after
            elif token in ("(", "[", "[["):
                i = parser.past(i)
            else:
                i += 1

    for i in range(parser.end):
        if parser.at(i) == "namespace" and parser.at(i + 1) == "{":
            level(i + 2, parser.past(i + 1) - 1)
    return names - {"", "operator", "__attribute__"} - MACROS, aliases


def called_names(parser):
    """Functions and types that are named without a namespace."""
    return {parser.at(i) for i in range(parser.end) if WORD.match(parser.at(i)) and
            (parser.at(i + 1) in ("(", "<") or parser.at(i)[0].isupper()) and parser.at(i - 1) not in (".", "->", "::")}


def is_alone(parser, own):
    """A class of a header whose members have types of the source: GCC takes such a class for one of many sources and warns."""
    for i in range(parser.end):
        if parser.at(i) in ("struct", "class") and parser.at(i + 2) == "::" and parser.at(i + 4) == "{":
            inside = {parser.at(k) for k in range(i + 5, parser.past(i + 4))}
            if any(name[0].isupper() for name in own & inside):
                return True
    return False


def groups(limit, sources):
    made, result = [], []  # of each group: size, names that its sources have for themselves, names that they call, aliases
    for source in sources:
        with open(source, encoding="utf-8") as file:
            text = file.read()
        parser = Parser(text)
        (own, aliases), called = own_names(text, parser), called_names(parser)
        if is_alone(parser, own):
            result.append("alone")
            continue
        for k, (size, group_own, group_called, group_aliases) in enumerate(made):
            different = {name for name in aliases if group_aliases.get(name, aliases[name]) != aliases[name]}
            if size < limit and not different and not own & (group_own | group_called | set(group_aliases)) and \
                    not (called | set(aliases)) & group_own:
                break
        else:
            k = len(made)
            made.append([0, set(), set(), {}])
        made[k][0] += 1
        made[k][1] |= own
        made[k][2] |= called
        made[k][3].update(aliases)
        result.append(k)
    return result


if __name__ == "__main__":
    print(*groups(int(sys.argv[1]), sys.argv[2:]), sep=";")
