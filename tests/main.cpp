#include <gtest/gtest.h>

#include <iostream>
#include <string>
#include <string_view>

// The tests of a folder are one program, which links once. ctest still runs and names each file of tests:
//   PROGRAM --file=thickness_test.cpp [options of GoogleTest]
// Without --file the program runs all of its tests.
namespace {

/// The filter that selects the tests of the source file `name`, empty where there are none.
std::string filter_of(std::string_view name) {
    const auto is_name = [name](std::string_view path) {
        return path.size() >= name.size() && path.substr(path.size() - name.size()) == name &&
               (path.size() == name.size() || path[path.size() - name.size() - 1] == '/');
    };
    std::string filter;
    const testing::UnitTest& program = *testing::UnitTest::GetInstance();
    for (int i = 0; i < program.total_test_suite_count(); ++i) {
        const testing::TestSuite& suite = *program.GetTestSuite(i);
        for (int j = 0; j < suite.total_test_count(); ++j) {
            const testing::TestInfo& test = *suite.GetTestInfo(j);
            if (is_name(test.file())) filter += std::string(suite.name()) + "." + test.name() + ":";
        }
    }
    return filter;
}

}  // namespace

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    const std::string_view option = "--file=";
    for (int i = 1; i < argc; ++i) {
        const std::string_view argument = argv[i];
        if (argument.substr(0, option.size()) != option) {
            std::cerr << argument << ": unknown option; known: --file=NAME.cpp and those of --help\n";
            return 2;
        }
        const std::string filter = filter_of(argument.substr(option.size()));
        if (filter.empty()) {
            std::cerr << argument << ": this program has no tests of that file\n";
            return 2;
        }
        GTEST_FLAG_SET(filter, filter);
    }
    return RUN_ALL_TESTS();
}
