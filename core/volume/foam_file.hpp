#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// OpenFOAM's files of one list: text or binary, labels of 32 or 64 bits, numbers of 32 or 64, any version's header.
/// Internal: programs use volume_file.hpp.
namespace strake::foam {

/// Position and format of a list in the file, to replace it.
struct ListPlace {
    std::size_t begin = 0, end = 0;  ///< the bytes between its parentheses
    bool is_binary = false;
    int scalar_bytes = 8;
};

/// A file, read from its header on. `bytes` outlive it; `name` is the file in messages.
class File {
public:
    /// @throws InputError without a `FoamFile` header, or with a format that is neither ascii nor binary.
    File(std::string_view bytes, std::string name);

    const std::string& kind() const { return class_; }  ///< "faceList", "faceCompactList", …
    std::vector<double> vectors(ListPlace& place);      ///< the next list, three numbers a row, all finite
    std::vector<int> labels();                          ///< the next list of whole numbers
    /// The next list of lists: offsets (one more than there are) and entries; text only.
    void label_lists(std::vector<int>& first, std::vector<int>& entries);

    /// Next word or mark of a dictionary; empty at the end.
    std::string_view token();
    [[noreturn]] void fail(const std::string& what) const;  ///< @throws InputError `NAME: byte N: what`

private:
    void read_header();
    void skip_blanks();
    void expect(char mark);
    bool meets(char mark);  ///< consumes it if it is next
    std::int64_t integer(const char* what);
    double scalar(int point);
    int count(std::size_t bytes_each);
    std::vector<int> binary_labels(int count);

    std::string_view bytes_;
    std::string name_, class_;
    std::size_t at_ = 0;
    bool is_binary_ = false;
    int label_bytes_ = 4, scalar_bytes_ = 8;
};

/// Replaces the points; all other bytes stay. @param points P x 3, row by row.
std::string with_vectors(std::string_view bytes, const ListPlace& place, const double* points, int count);

}  // namespace strake::foam
