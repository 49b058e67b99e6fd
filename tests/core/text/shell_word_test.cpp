#include "core/text/shell_word.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/mesh/temp_folder.hpp"

/// Words go through real shells and come back as the same bytes.
namespace strake {
namespace {

const std::vector<std::string>& hard_words() {
    static const std::vector<std::string> words{"",
                                                " ",
                                                "plain",
                                                "my run",
                                                "it's",
                                                "'",
                                                "''",
                                                "a'b'c",
                                                "\n",
                                                "two\nlines",
                                                "end\n",
                                                "\t",
                                                "~",
                                                "~root/x",
                                                "-n",
                                                "--help",
                                                "-",
                                                "=x",
                                                "A=b",
                                                "x=~",
                                                "*",
                                                "?",
                                                "[a-z]*",
                                                "{a,b}",
                                                "#",
                                                "# a comment",
                                                "!",
                                                "!!",
                                                "a!b",
                                                "$HOME",
                                                "${x}",
                                                "$(echo hi)",
                                                "`echo hi`",
                                                "\\",
                                                "\\n",
                                                "a\\",
                                                "\"",
                                                "\"a b\"",
                                                "a;b",
                                                "a&b",
                                                "a|b",
                                                "<x",
                                                ">x",
                                                "(x)",
                                                "%s",
                                                "if",
                                                "cd",
                                                "{}",
                                                "\r",
                                                "a\rb",
                                                "\x01\x7f",
                                                "fl\xC3\xBCgel",
                                                "\xff\xfe",
                                                "a\xff"
                                                "1",
                                                "\x1b[31m",
                                                "a\n'b'\\c"};
    return words;
}

/// What the shell makes of `word`, which stands in a line as it is.
std::string read_back(const std::string& shell, const std::string& word) {
    const TempFolder folder;
    const auto script =
        folder.write("script", "set -- " + word + "\n[ $# = 1 ] || { echo \"$# words\"; exit; }\nprintf %s \"$1\"\n");
    std::FILE* pipe = ::popen(("cd / && HOME=/home " + shell + " " + script.string()).c_str(), "r");
    std::string out;
    for (int c; pipe != nullptr && (c = std::fgetc(pipe)) != EOF;) out += static_cast<char>(c);
    EXPECT_EQ(::pclose(pipe), 0) << shell << ": " << word;
    return out;
}

bool has(const std::string& program) { return std::system(("command -v " + program + " > /dev/null").c_str()) == 0; }

}  // namespace

TEST(ShellWord, EveryShellReadsBackTheBytes) {
    for (const std::string shell : {"sh", "bash", "zsh", "dash"}) {
        if (!has(shell)) continue;
        for (const std::string& word : hard_words())
            EXPECT_EQ(read_back(shell, shell_word(word)), word) << shell << ": " << shell_word(word);
    }
}

TEST(ShellWord, PathsThatAreTypedNameTheSameFile) {
    for (const std::string shell : {"bash", "zsh"}) {
        if (!has(shell)) continue;
        for (const std::string& word : hard_words()) {
            const std::string dashed = word.starts_with('-') ? "./" + word : word;
            EXPECT_EQ(read_back(shell, typed_path(word)), dashed) << shell << ": " << typed_path(word);
        }
    }
}

TEST(ShellWord, WhatIsPlainStaysBareAndNothingUnseenIsShown) {
    EXPECT_EQ(typed_path("runs/wing_2-best.v1"), "runs/wing_2-best.v1");
    EXPECT_EQ(typed_path("my run"), "'my run'");
    EXPECT_EQ(typed_path("fl\xC3\xBCgel"), "'fl\xC3\xBCgel'");
    EXPECT_EQ(typed_path("-x"), "./-x");
    EXPECT_EQ(typed_path(""), "''");
    for (const std::string& word : hard_words())
        for (const char c : typed_path(word))
            EXPECT_TRUE(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) << typed_path(word);
}

}  // namespace strake
