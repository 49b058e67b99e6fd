#include "core/text/base64.hpp"
#include "core/text/edit_distance.hpp"
#include "core/text/hash.hpp"
#include "core/text/utf8.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

TEST(Base64, IsThatOfTheStandard) {
    // RFC 4648, section 10.
    EXPECT_EQ(base64(""), "");
    EXPECT_EQ(base64("f"), "Zg==");
    EXPECT_EQ(base64("fo"), "Zm8=");
    EXPECT_EQ(base64("foo"), "Zm9v");
    EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
    EXPECT_EQ(base64("\xff\xfe"), "//4=");
}

TEST(Base64, DigitsAreThoseThatItWrites) {
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t i = 0; i < letters.size(); ++i) EXPECT_EQ(base64_digit(letters[i]), static_cast<int>(i));
    for (const char c : {'=', '-', '_', ' ', '\0'}) EXPECT_EQ(base64_digit(c), -1);
}

TEST(Utf8, TakesWhatTheStandardAllows) {
    const auto is = [](std::string_view bytes, std::size_t length, char32_t code) {
        const Utf8Character c = utf8_at(bytes, 0);
        EXPECT_EQ(c.length, length) << bytes;
        EXPECT_EQ(c.code, code) << bytes;
    };
    is("a", 1, U'a');
    is("\xC2\x80", 2, 0x80);
    is("\xC3\xA4", 2, U'ä');
    is("\xDF\xBF", 2, 0x7FF);
    is("\xE0\xA0\x80", 3, 0x800);
    is("\xE2\x82\xAC", 3, U'€');
    is("\xF0\x90\x80\x80", 4, 0x10000);
    is("\xF4\x8F\xBF\xBF", 4, 0x10FFFF);
    EXPECT_EQ(utf8_at("x\xC3\xA4", 1).code, U'ä');
}

TEST(Utf8, RefusesOverlongCutOffAndForbiddenSequences) {
    for (const char* bytes : {"\x80", "\xC0\x80", "\xC1\xBF", "\xC3", "\xC3\x28", "\xE0\x9F\xBF", "\xE2\x82",
                              "\xED\xA0\x80", "\xF0\x8F\xBF\xBF", "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFF"})
        EXPECT_EQ(utf8_at(bytes, 0).length, 0u) << bytes;
}

TEST(Utf8, ControlCharactersOfBothPages) {
    for (const char32_t code : {0x0, 0x1F, 0x7F, 0x80, 0x9F}) EXPECT_TRUE(is_control(code)) << int(code);
    for (const char32_t code : {0x20, 0x7E, 0xA0, 0x200E}) EXPECT_FALSE(is_control(code)) << int(code);
}

TEST(Hash, IsFnv1a) {
    // Landon Curt Noll's test vectors.
    EXPECT_EQ(hash_digits(fnv1a("")), "cbf29ce484222325");
    EXPECT_EQ(hash_digits(fnv1a("a")), "af63dc4c8601ec8c");
    EXPECT_EQ(hash_digits(fnv1a("foobar")), "85944171f73967e8");
    EXPECT_EQ(fnv1a("bar", fnv1a("foo")), fnv1a("foobar"));
}

TEST(EditDistance, CountsInsertionsDeletionsAndReplacements) {
    EXPECT_EQ(edit_distance("", ""), 0);
    EXPECT_EQ(edit_distance("drag", "drag"), 0);
    EXPECT_EQ(edit_distance("dragg", "drag"), 1);
    EXPECT_EQ(edit_distance("mim", "min"), 1);
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
    EXPECT_EQ(edit_distance("", "abc"), 3);
}

}  // namespace
}  // namespace strake
