#pragma once
#include "casefile/build/build_problem.hpp"
#include "casefile/load_case.hpp"
#include "surfaces.hpp"
#include "tests/casefile/folder.hpp"

#include <gtest/gtest.h>

namespace strake {

/// Builds problems from cases about one surface file.
class BuildProblem : public testing::Test {
protected:
    Folder folder;

    void surface(const TriMesh& mesh) { write_surface(folder.path() / "s.obj", mesh, SurfaceFormat::obj); }
    BuiltProblem build(const std::string& yaml, Purpose purpose = Purpose::any) {
        return build_problem(load_case(folder.write("case.yaml", "case: c\nsurface: {file: s.obj}\n" + yaml), purpose),
                             purpose);
    }
    /// The message of the error, without the folder.
    std::string error(const std::string& yaml, Purpose purpose = Purpose::any) {
        std::string message;
        try {
            build(yaml, purpose);
        } catch (const InputError& e) {
            message = e.what();
        } catch (const CaseError& e) {
            message = e.what();
        }
        const std::string prefix = folder.path().string() + "/";
        for (std::size_t at; (at = message.find(prefix)) != std::string::npos;) message.erase(at, prefix.size());
        return message;
    }
    static bool contains(const std::string& all, const std::string& part) {
        return all.find(part) != std::string::npos;
    }
    static const std::vector<int>& region(const BuiltProblem& built, const std::string& name) {
        for (const RegionTriangles& r : built.regions)
            if (r.name == name) return r.triangles;
        throw std::out_of_range(name);
    }
};

}  // namespace strake
