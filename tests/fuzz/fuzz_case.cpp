#include "casefile/load_case.hpp"
#include "casefile/model/case.hpp"
#include "casefile/read/resolved_case.hpp"
#include "tests/casefile/folder.hpp"

/// Whatever the text is, the loader of cases ends in a case or in a CaseError; a case that it takes is resolved to one
/// that it takes, too.
extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
    using namespace strake;
    static const Folder folder;
    static const bool has_files = [] {
        folder.write("wing.obj", tetrahedron_obj);
        for (const char* name : {"flap.txt", "lines.csv", "points.csv", "run.sh"}) folder.write(name, "1,2,3\n");
        return true;
    }();
    (void)has_files;
    const auto file = folder.write("case.yaml", std::string(reinterpret_cast<const char*>(data), size));
    try {
        const Case the_case = load_case(file);
        const std::string resolved = resolved_case(the_case, folder.path());
        load_case(folder.write("resolved.yaml", resolved));
    } catch (const CaseError&) {
    }
    return 0;
}
