#!/usr/bin/python3
"""Finds functions that are too long or too hard to follow: check_functions.py [--clang-tidy BUILD] [--self-test] [FILE...]

More than 80 lines, or a cognitive complexity above 25 (as clang-tidy counts it: readability-function-size,
readability-function-cognitive-complexity). By itself the script counts from the tokens, in two seconds; with --clang-tidy
the compiler's own parser counts, in some ten minutes of CPU: BUILD is a configured build folder without STRAKE_UNITY and
STRAKE_PRECOMPILE. Without FILE: all sources.
Exit status: 0 nothing found, 1 something found, 2 wrong usage.
"""

import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

MAX_LINES = 80
MAX_COMPLEXITY = 25
FOLDERS = ["core", "objectives", "optimize", "casefile", "cases", "viewer", "report", "cli", "python", "studio", "bench"]

TOKEN = re.compile(
    r"""(?P<skip>//[^\n]*|/\*.*?\*/|\#(?:[^\n\\]|\\.)*|\\\n|[ \t\r\f]+)|(?P<line>\n)|(?P<raw>R"(?P<tag>\w*)\(.*?\)(?P=tag)")
    |(?P<text>"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+')|(?P<word>\w+(?:'\w+)*(?:\.\d\w*)?)
    |(?P<sign>&&|\|\||::|->|<<=|>>=|==|!=|<=|>=|\[\[|[-+*/%&|^]=|.)""", re.S | re.X)
PAIR = {"(": ")", "[": "]", "{": "}", "[[": "]]"}


def tokens(text):
    """[(token, line)]; texts become two quotes."""
    found, line = [], 1
    for match in TOKEN.finditer(text):
        kind, token = match.lastgroup, match.group()
        if kind == "line":
            line += 1
            continue
        if kind == "tag":
            kind = "raw"
        if kind in ("word", "sign"):
            found.append((token, line))
        elif kind in ("text", "raw"):
            found.append(('""', line))
        line += token.count("\n")
    return found


class Parser:
    """Functions of a file with their lines and their complexity."""

    def __init__(self, text):
        self.all = tokens(text)
        self.end = len(self.all)
        self.functions = []  # (line, name, lines, complexity)
        self.close = {}
        stack, second = [], -1
        for i, (token, _) in enumerate(self.all):
            if token in PAIR:
                stack.append(i)
            elif token in (")", "]", "}") and stack and i != second:
                opened = stack.pop()
                if self.at(opened) == "[[":  # closed by two
                    second = i + 1
                self.close[opened] = second if second > i else i
        self.declarations(0, self.end)

    def at(self, i):
        return self.all[i][0] if 0 <= i < self.end else ""

    def past(self, i):
        """Behind the bracket that token i opens."""
        return self.close.get(i, self.end - 1) + 1

    def declarations(self, i, end):
        start = i
        while i < end:
            token = self.at(i)
            if token in (";", "}"):
                i += 1
                start = i
            elif token == ":" and self.at(i - 1) in ("public", "private", "protected"):
                i += 1
                start = i
            elif token == "{":
                i = self.braces(start, i, end)
                start = i
            elif token in ("(", "[", "[["):
                i = self.past(i)
            else:
                i += 1

    def braces(self, start, i, end):
        """The brace at i ends the head of a declaration that begins at start."""
        head = [self.at(k) for k in range(start, i)]
        if "namespace" in head or head[:1] == ["extern"] and len(head) == 2:
            self.declarations(i + 1, self.past(i) - 1)
            return self.past(i)
        call = self.parameters(start, i)
        if call is None:
            if any(word in head for word in ("struct", "class", "union")) and "enum" not in head:
                self.declarations(i + 1, self.past(i) - 1)
            return self.past(i)  # or an initializer
        # An initializer list in front of the body: name{...} or name(...), then a comma.
        k = self.past(call)
        while k < i and self.at(k) != ":":
            k = self.past(k) if self.at(k) in ("(", "[", "[[") else k + 1
        if k < i or self.at(i - 1) != ")" and self.at(k) == ":":
            k += 1
            while k < end:
                while self.at(k) not in ("(", "{"):
                    k += 1
                k = self.past(k)
                if self.at(k) != ",":
                    break
                k += 1
            i = k
        name = "".join(self.at(k) for k in self.name_before(call))
        complexity = Complexity(self, name.split("::")[-1])
        complexity.block(i, 0)
        last = self.past(i) - 1
        self.functions.append((self.all[call][1], name, self.all[last][1] - self.all[i][1], complexity.sum))
        return last + 1

    def parameters(self, start, end):
        """The bracket of a function's parameters in a head, or None."""
        k = start
        while k < end:
            token = self.at(k)
            if token == "=" and self.at(k - 1) != "operator":
                return None
            if token == "operator":  # operator()(...), operator[](...)
                k += 1
                k = self.past(k) if self.at(k) in ("(", "[") else k + 1
                continue
            if token == "(":
                if self.at(k - 1) in ("requires", "decltype", "noexcept", "alignas", "__attribute__"):
                    k = self.past(k)
                    continue
                return k
            k = self.past(k) if token in ("[", "[[", "{") else k + 1
        return None

    def name_before(self, i):
        k = i - 1
        while k > 0 and (re.match(r"\w", self.at(k)) or self.at(k) in ("~", "::")) and (
                self.at(k) in ("::", "~") or self.at(k + 1) in ("::", "(", "~")):
            k -= 1
        return range(k + 1, i)


class Complexity:
    """Cognitive complexity of a body: one more for each break of the flow, and one for each level that it lies in."""

    def __init__(self, parser, name):
        self.p, self.name, self.sum = parser, name, 0

    def block(self, i, depth):
        """The braces at i."""
        end, i = self.p.past(i) - 1, i + 1
        while i < end:
            i = self.statement(i, depth)
        return end + 1

    def statement(self, i, depth, is_else=False):
        """Counts the statement at i and returns the place behind it."""
        p = self.p
        token = p.at(i)
        if token == "{":
            return self.block(i, depth)
        if token == "if":
            i += 1
            if p.at(i) == "constexpr":
                i += 1
            self.sum += 1 if is_else else 1 + depth
            after = p.past(i)
            self.expression(i + 1, after - 1, depth)
            i = self.statement(after, depth + 1)
            if p.at(i) == "else":
                i += 1
                if p.at(i) == "if":
                    return self.statement(i, depth, True)
                self.sum += 1
                i = self.statement(i, depth + 1)
            return i
        if token in ("for", "while", "switch"):
            self.sum += 1 + depth
            after = p.past(i + 1)
            self.expression(i + 2, after - 1, depth + 1)
            return self.statement(after, depth + 1)
        if token == "do":
            self.sum += 1 + depth
            i = self.statement(i + 1, depth + 1)  # to `while`
            after = p.past(i + 1)
            self.expression(i + 2, after - 1, depth + 1)
            return after + 1
        if token == "try":
            i = self.statement(i + 1, depth)
            while p.at(i) == "catch":
                self.sum += 1 + depth
                i = self.statement(p.past(i + 1), depth + 1)
            return i
        if token == "goto":
            self.sum += 1
        if token in ("case", "default"):
            while p.at(i) != ":":
                i += 1
            return i + 1
        if token in ("struct", "class", "union", "enum") and self.is_type(i):
            while p.at(i) != "{":
                i += 1
            inner = p.past(i)
            if token != "enum":
                before = len(p.functions)
                p.declarations(i + 1, inner - 1)
                self.sum += sum(function[3] for function in p.functions[before:])
            return inner
        k = i
        while k < p.end and p.at(k) not in (";", "}"):
            k = p.past(k) if p.at(k) in PAIR else k + 1
        self.expression(i, k, depth)
        return k + 1 if p.at(k) == ";" else max(k, i + 1)

    def is_type(self, i):
        """Whether a type is defined here, rather than named."""
        while self.p.at(i) not in (";", "{", "(", "=", ""):
            i += 1
        return self.p.at(i) == "{"

    def expression(self, i, end, depth, above=""):
        """Operators, choices, lambdas and calls of the function itself between i and end."""
        p = self.p
        begin, choices = i, 0
        for part in self.parts(i, end, (",", ";", "?", ":", "=")):
            self.sum += self.sequences(*part, above)
        while i < end:
            token = p.at(i)
            if token == "?":
                self.sum += 1 + depth + choices
                choices += 1
                i += 1
            elif token in (",", ";"):
                choices = 0
                i += 1
            elif token == "[" and not self.is_subscript(i, begin):
                i = self.lambda_at(i, end, depth + choices)
            elif token in ("(", "[", "{"):
                inner = p.past(i)
                is_call = token != "(" or i > begin and (re.match(r"\w", p.at(i - 1)) or p.at(i - 1) in (")", "]", ">"))
                if is_call and token == "(" and p.at(i - 1) == self.name and p.at(i - 2) not in (".", "->", "::"):
                    self.sum += 1
                self.expression(i + 1, inner - 1, depth + choices, "" if is_call else self.operator_around(i, begin, end, above))
                i = inner
            elif token == "[[":
                i = p.past(i)
            else:
                i += 1

    def parts(self, i, end, separators):
        begin = i
        while i < end:
            token = self.p.at(i)
            if token in separators:
                yield begin, i
                begin = i + 1
            i = self.p.past(i) if token in PAIR else i + 1
        yield begin, end

    def sequences(self, i, end, above):
        """How many runs of the same logical operator there are between i and end, brackets left out."""
        groups = list(self.parts(i, end, ("||", "or")))
        found = 1 if len(groups) > 1 and above != "||" else 0
        around = "||" if len(groups) > 1 else above
        for group in groups:
            found += 1 if len(list(self.parts(*group, ("&&", "and")))) > 1 and around != "&&" and self.is_logical(*group) else 0
        return found

    def is_logical(self, i, end):
        """Whether && is an operator here, not a reference: `auto&& x`, `T&& x`."""
        declared = self.p.at(i) in ("auto", "const") and self.p.at(i + 1) in ("auto", "&&")
        return not declared

    def operator_around(self, i, begin, end, above):
        """The logical operator that brackets at i are an operand of, if one is."""
        for part in self.parts(begin, end, (",", ";", "?", ":", "=")):
            if part[0] <= i < part[1]:
                groups = list(self.parts(*part, ("||", "or")))
                for group in groups:
                    if group[0] <= i < group[1] and len(list(self.parts(*group, ("&&", "and")))) > 1:
                        return "&&"
                return "||" if len(groups) > 1 else above
        return above

    def is_subscript(self, i, begin):
        before = self.p.at(i - 1)
        if i == begin and before in ("return", "(", ",", "{", ";", "}", "="):
            return False
        return bool(re.match(r"\w", before)) and before not in ("return", "co_return", "throw") or before in (")", "]", ">", '""')

    def lambda_at(self, i, end, depth):
        p = self.p
        i = p.past(i)
        while i < end and p.at(i) != "{":
            i = p.past(i) if p.at(i) in ("(", "[", "[[") else i + 1
        return self.block(i, depth + 1) if i < end else end


def too_much(file):
    with open(file, encoding="utf-8") as source:
        functions = Parser(source.read()).functions
    problems = []
    for line, name, lines, complexity in functions:
        if lines > MAX_LINES:
            problems.append(f"{file}:{line}: {name} has {lines} lines (limit: {MAX_LINES})")
        if complexity > MAX_COMPLEXITY:
            problems.append(f"{file}:{line}: {name} has a cognitive complexity of {complexity} (limit: {MAX_COMPLEXITY})")
    return problems, functions


def clang_tidy(build, files):
    options = {"readability-function-size.LineThreshold": MAX_LINES, "readability-function-size.StatementThreshold": 100000,
               "readability-function-cognitive-complexity.Threshold": MAX_COMPLEXITY,
               "readability-function-cognitive-complexity.DescribeBasicIncrements": 0}
    config = "{CheckOptions: [" + ", ".join(f"{{key: {key}, value: {value}}}" for key, value in options.items()) + "]}"

    def one(file):
        done = subprocess.run(["clang-tidy", "-p", build, f"--config={config}", "--quiet", file, "--header-filter=.*",
                               "--checks=-*,readability-function-size,readability-function-cognitive-complexity"],
                              capture_output=True, text=True, check=False)
        found = [line for line in done.stdout.splitlines() if re.search(r" (warning|error): ", line)]
        return found + ([f"{file}: {done.stderr}"] if done.returncode and not found else [])

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return sorted({line for lines in pool.map(one, files) for line in lines})


def self_test():
    cases = [
        ("int f(int a) { if (a) return 1; else return 2; }", 2),
        ("int f(int a) { if (a) { for (;;) { if (a) break; } } return 0; }", 6),
        ("bool f(bool a, bool b, bool c) { return a && b && c; }", 1),
        ("bool f(bool a, bool b, bool c) { return a && b || c; }", 2),
        ("bool f(bool a, bool b, bool c) { return a || (b && c) || a; }", 2),
        ("bool f(bool a, bool b, bool c) { return a && (b && c); }", 1),
        ("bool f(bool a, bool b, bool c) { return a && g(b && c); }", 2),
        ("int f(int a) { return a ? 1 : a > 2 ? 3 : 4; }", 3),
        ("int f(int a) { const auto g = [&](int b) { if (b) return 1; return 2; }; return g(a); }", 2),
        ("int f(int a) { if (a) return 1; else if (a > 2) return 3; else return 4; }", 3),
        ("int f(int a) { switch (a) { case 1: if (a) return 2; default: return 3; } }", 3),
        ("int f(int a) { return a ? f(a - 1) : 0; }", 2),
        ("void f() { try { g(); } catch (const E& e) { if (e) throw; } }", 3),
        ("void f(std::vector<int>&& a) { auto&& b = a; do { ++b; } while (b && a); }", 2),
        ("struct S { S(int a) : a_(a), b_{a ? 1 : 2} { if (a) b_ = 0; } int a_, b_; };", 1),
        ("void f(int a) { while (a) for (;;) if (a) { return; } }", 6),
    ]
    wrong = 0
    for text, expected in cases:
        found = [function[3] for function in Parser(text).functions]
        if found != [expected]:
            wrong += 1
            print(f"self-test: {text}: expected {expected}, counted {found}")
    long = "void f() {\n" + "g();\n" * 80 + "}\n"
    if [function[2] for function in Parser(long).functions] != [81]:
        wrong += 1
        print("self-test: a function of 81 lines:", Parser(long).functions)
    print(f"self-test: {len(cases) + 1} functions, {wrong} wrong")
    return wrong


# Functions over the limit that are still to be split. The list may only shrink: a function that is not in it fails, and so
# does an entry that is no longer needed.
TO_BE_SPLIT = {
    ("optimize/evaluate/combinations.cpp", "Combinations::differentiate"),
    ("optimize/nlp/program/finite_differences.cpp", "differentiate_by_differences"),
    ("optimize/space/design_levels.cpp", "place_cores"),
    ("optimize/space/design_levels.cpp", "offer"),
}


def known(problem):
    """The entry of the list that a line of problems is about; None: a new one."""
    file, _, rest = problem.split(":", 2)
    entry = (file, rest.split()[0])
    return entry if entry in TO_BE_SPLIT else None


def main():
    arguments = sys.argv[1:]
    if "--self-test" in arguments:
        arguments.remove("--self-test")
        if self_test():
            return 1
    build = None
    if arguments[:1] == ["--clang-tidy"] and len(arguments) > 1:
        build, arguments = arguments[1], arguments[2:]
    everything = "--list" in arguments
    files = [argument for argument in arguments if argument != "--list"]
    if any(file.startswith("-") for file in files):
        print(__doc__.split("\n")[0], file=sys.stderr)
        return 2
    os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
    files = files or sorted(os.path.join(folder, name) for top in FOLDERS for folder, _, names in os.walk(top) for name in names
                            if name.endswith((".cpp", ".hpp")))
    if build:
        problems = clang_tidy(build, [file for file in files if file.endswith(".cpp")])
        count = f"{len(files)} files"
    else:
        results = [too_much(file) for file in files]
        problems = [problem for result in results for problem in result[0]]
        count = f"{sum(len(result[1]) for result in results)} functions in {len(files)} files"
        if everything:
            for file, result in zip(files, results):
                for line, name, lines, complexity in result[1]:
                    print(f"{complexity:4d} {lines:4d} {file}:{line}: {name}")
    if not build:
        met = {known(problem) for problem in problems}
        checked = {(file, name) for file, name in TO_BE_SPLIT if file in files}
        problems = [problem for problem in problems if not known(problem)]
        problems += [f"{file}: {name} is within the limits: take it from the list" for file, name in sorted(checked - met)]
    print(*problems, sep="\n", end="\n" if problems else "")
    print(f"{count}, {len(problems)} problems")
    return 1 if problems or not files else 0


if __name__ == "__main__":
    sys.exit(main())
