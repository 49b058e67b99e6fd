#include "objectives/external/shared_library.hpp"

#include "core/error.hpp"

#include <elf.h>
#include <algorithm>
#include <cstring>
#include <fstream>
#include <vector>

namespace strake {
namespace {

/// Reads a record at `at`; false where the file ends before it does.
template <class Record>
bool read_at(std::ifstream& file, std::uint64_t at, Record& record) {
    file.clear();
    file.seekg(static_cast<std::streamoff>(at));
    return bool(file.read(reinterpret_cast<char*>(&record), sizeof record));
}

}  // namespace

std::string cut_short(const std::filesystem::path& library) {
    std::error_code why;
    const std::uint64_t size = std::filesystem::file_size(library, why);
    std::ifstream file(library, std::ios::binary);
    char magic[EI_NIDENT] = {};
    if (why || !read_at(file, 0, magic) || std::memcmp(magic, ELFMAG, SELFMAG) != 0 || magic[EI_CLASS] != ELFCLASS64)
        return "";  // dlopen has words for that
    Elf64_Ehdr head{};
    std::uint64_t wanted = sizeof head;
    if (read_at(file, 0, head)) {
        constexpr std::uint64_t largest = std::uint64_t{1} << 62;  // beyond it the sums below could wrap around
        wanted = std::max(wanted, std::min(head.e_phoff, largest) + std::uint64_t{head.e_phnum} * head.e_phentsize);
        if (head.e_shnum > 0)
            wanted = std::max(wanted, std::min(head.e_shoff, largest) + std::uint64_t{head.e_shnum} * head.e_shentsize);
        for (int k = 0; k < head.e_phnum; ++k) {
            Elf64_Phdr part{};
            if (!read_at(file, head.e_phoff + std::uint64_t{head.e_phentsize} * static_cast<unsigned>(k), part)) break;
            wanted = std::max(wanted, std::min(part.p_offset, largest) + std::min(part.p_filesz, largest));
        }
    }
    if (wanted <= size) return "";
    return text("is cut short: it has ", size, " bytes, its header asks for ", wanted, "; copy or build it again");
}

}  // namespace strake
