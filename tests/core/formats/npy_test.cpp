#include "core/formats/npy.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

/// Arrays as NumPy writes them: both byte orders, both orders of storage, both sizes of number.
namespace strake {
namespace {

std::string array(const std::string& dictionary, const std::string& data, int version = 1) {
    std::string header = dictionary + "\n", bytes = "\x93NUMPY";
    bytes += {static_cast<char>(version), '\0', static_cast<char>(header.size()), '\0'};
    if (version > 1) bytes += std::string(2, '\0');
    return bytes + header + data;
}

template <class Number>
std::string bytes_of(const std::vector<Number>& values, bool swap = false) {
    std::string bytes;
    for (const Number value : values) {
        char raw[sizeof(Number)];
        std::memcpy(raw, &value, sizeof raw);
        if (swap) std::reverse(raw, raw + sizeof raw);
        bytes.append(raw, sizeof raw);
    }
    return bytes;
}

std::string refusal(const std::string& bytes) {
    try {
        parse_npy(bytes);
    } catch (const NpyError& error) {
        return error.what();
    }
    return "";
}

TEST(NpyTest, ReadsEveryKindOfFloatInEveryOrder) {
    const std::vector<double> rows{1, 2, 3, 4, 5, -6.5}, columns{1, 4, 2, 5, 3, -6.5};
    const std::vector<float> small(rows.begin(), rows.end()), small_columns(columns.begin(), columns.end());
    Points expected(2, 3);
    expected << 1, 2, 3, 4, 5, -6.5;
    for (const std::string order : {"False", "True"}) {
        const bool is_fortran = order == "True";
        const auto header = [&](const std::string& type) {
            return "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': (2, 3), }";
        };
        const auto& numbers = is_fortran ? columns : rows;
        const auto& floats = is_fortran ? small_columns : small;
        EXPECT_EQ(parse_npy(array(header("<f8"), bytes_of(numbers))), expected);
        EXPECT_EQ(parse_npy(array(header(">f8"), bytes_of(numbers, true))), expected);
        EXPECT_EQ(parse_npy(array(header("<f4"), bytes_of(floats))), expected);
        EXPECT_EQ(parse_npy(array(header(">f4"), bytes_of(floats, true), 2)), expected);
    }
}

TEST(NpyTest, WritesWhatItReads) {
    Points points(3, 3);
    points << 0.1, -0.0, 1e-310, 3, 4, 5, 1e308, std::nan(""), -7;
    const std::string bytes = npy_bytes(points);
    EXPECT_EQ((bytes.size() - 72) % 64, 0u) << "data begins at a multiple of 64";
    const Points read = parse_npy(bytes);
    EXPECT_EQ(std::memcmp(read.data(), points.data(), 72), 0);
    EXPECT_EQ(parse_npy(npy_bytes(Points(0, 3))).rows(), 0);
}

TEST(NpyTest, SaysWhatIsWrong) {
    const std::string good = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 3), }", data(24, '\0');
    const auto with = [&](const std::string& what, const std::string& by) {
        std::string header = good;
        return array(header.replace(header.find(what), what.size(), by), data);
    };
    EXPECT_EQ(refusal(array(good, data)), "");
    EXPECT_NE(refusal("1,2,3").find("no NumPy array"), std::string::npos);
    EXPECT_NE(refusal(array(good, data).substr(0, 30)).find("ends inside its header"), std::string::npos);
    EXPECT_NE(refusal(array(good, data + "x")).find("25 bytes"), std::string::npos);
    EXPECT_NE(refusal(with("<f8", "<i8")).find("'<i8'"), std::string::npos);
    EXPECT_NE(refusal(with("'<f8'", "[('x', '<f8')]")).find("must be a type of number"), std::string::npos);
    EXPECT_NE(refusal(with("(1, 3)", "(3,)")).find("must be (n, 3)"), std::string::npos);
    EXPECT_NE(refusal(with("(1, 3)", "(1, 3, 1)")).find("must be (n, 3)"), std::string::npos);
    EXPECT_NE(refusal(with("(1, 3)", "(1, 4)")).find("must be (n, 3)"), std::string::npos);
    EXPECT_NE(refusal(with("(1, 3)", "(-1, 3)")).find("must be (n, 3)"), std::string::npos);
    EXPECT_NE(refusal(with("(1, 3)", "(9223372036854775807, 3)")).find("24 bytes"), std::string::npos);
    EXPECT_NE(refusal(with("(1, 3)", "(99999999999999999999, 3)")).find("must be (n, 3)"), std::string::npos);
    EXPECT_NE(refusal(with("False", "Maybe")).find("neither"), std::string::npos);
    EXPECT_NE(refusal(with("'shape'", "'form'")).find("no 'shape'"), std::string::npos);
}

TEST(NpyTest, NothingThatIsCutOffOrDamagedCrashes) {
    const std::string whole = npy_bytes(Points::Ones(4, 3));
    for (std::size_t n = 0; n < whole.size(); ++n) EXPECT_NE(refusal(whole.substr(0, n)), "") << n;
    for (std::size_t at = 0; at < 128; ++at)
        for (const char damage : {'\0', '\xff', '(', '\''}) {
            std::string bytes = whole;
            bytes[at] = damage;
            refusal(bytes);
        }
}

}  // namespace
}  // namespace strake
