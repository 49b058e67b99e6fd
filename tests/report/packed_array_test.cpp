#include "report/packed_array.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

namespace strake {
namespace {

std::string from_base64(const std::string& words) {
    static const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : words) {
        if (c == '=') break;
        bits = bits << 6 | static_cast<std::uint32_t>(letters.find(c));
        count += 6;
        if (count >= 8) count -= 8, bytes += static_cast<char>(bits >> count & 0xff);
    }
    return bytes;
}

/// As report/page/src/packed.js does it.
template <class Whole>
std::vector<Whole> unpacked(const std::string& words, std::size_t size, std::size_t columns) {
    const std::string packed = from_base64(words);
    std::string planes(sizeof(Whole) * size, '\0');
    uLongf bytes = static_cast<uLongf>(planes.size());
    EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(planes.data()), &bytes, reinterpret_cast<const Bytef*>(packed.data()),
                         static_cast<uLong>(packed.size())),
              Z_OK);
    EXPECT_EQ(bytes, planes.size());
    std::vector<Whole> values(size);
    for (std::size_t i = 0; i < size; ++i) {
        Whole difference = 0;
        for (std::size_t b = 0; b < sizeof(Whole); ++b)
            difference = static_cast<Whole>(
                difference | static_cast<Whole>(static_cast<unsigned char>(planes[b * size + i])) << (8 * b));
        values[i] = static_cast<Whole>(difference + (i >= columns ? values[i - columns] : Whole{0}));
    }
    return values;
}

TEST(PackedArray, ComesBack) {
    std::vector<std::uint16_t> small;
    std::vector<std::uint32_t> large;
    for (std::uint32_t i = 0; i < 3000; ++i) {
        small.push_back(static_cast<std::uint16_t>(i * 40503U));  // wraps, up and down
        large.push_back(i * 2654435761U);
    }
    EXPECT_EQ(unpacked<std::uint16_t>(packed_array(small, 3), small.size(), 3), small);
    EXPECT_EQ(unpacked<std::uint32_t>(packed_array(large, 3), large.size(), 3), large);
}

TEST(PackedArray, EmptyAndCrookedOnes) {
    EXPECT_TRUE(unpacked<std::uint16_t>(packed_array(std::vector<std::uint16_t>{}, 3), 0, 3).empty());
    EXPECT_THROW(packed_array(std::vector<std::uint16_t>{1, 2, 3, 4}, 3), InvalidInput);
    EXPECT_THROW(packed_array(std::vector<std::uint16_t>{1, 2}, 0), InvalidInput);
}

TEST(PackedArray, NeighboursThatAreAlikePackWell) {
    std::vector<std::uint16_t> smooth;
    for (int i = 0; i < 30000; ++i) smooth.push_back(static_cast<std::uint16_t>(20000 + i / 3));
    EXPECT_LT(packed_array(smooth, 3).size(), smooth.size() / 10);
}

}  // namespace
}  // namespace strake
