#include "report/design_fields.hpp"

#include "core/error.hpp"
#include "core/mesh/temp_folder.hpp"
#include "objectives/fit/target_shape.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

namespace fs = std::filesystem;

class DesignFields : public testing::Test {
protected:
    TempFolder folder;
    Problem problem;
    std::vector<std::string> problems;

    void SetUp() override { problem.surface = ellipsoid({1, 0.7, 0.5}, 1); }
    int vertices() const { return problem.surface.num_vertices(); }
    std::vector<Field> fields() { return design_fields(problem, {problem.surface, folder.path()}, problems); }
    /// Row k holds 0.5 k; backwards, under a header.
    std::string rows() const {
        std::string csv = "index,cp\n";
        for (int k = vertices() - 1; k >= 0; --k) csv += std::to_string(k) + "," + std::to_string(0.5 * k) + "\r\n";
        return csv;
    }
    std::string problem_of(const std::string& entry, const std::string& csv) {
        problems.clear();
        folder.write("cp.csv", csv);
        folder.write("result.json", "{\"value\": 1, \"fields\": {" + entry + "}}");
        EXPECT_TRUE(fields().empty());
        return problems.size() == 1 ? problems[0] : std::to_string(problems.size()) + " problems";
    }
};

TEST_F(DesignFields, DistanceToTheWantedShape) {
    TriMesh target = problem.surface;
    target.vertices.rowwise() += Eigen::RowVector3d(0, 0.03, 0.04);
    problem.quantities = {target_shape_same("match", problem.surface, target)};
    const std::vector<Field> found = fields();
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].name, "match.distance");
    const auto& distance = std::get<Eigen::VectorXd>(found[0].values);
    ASSERT_EQ(distance.size(), vertices());
    EXPECT_NEAR(distance.minCoeff(), 0.05, 1e-12);
    EXPECT_NEAR(distance.maxCoeff(), 0.05, 1e-12);
    EXPECT_TRUE(problems.empty());
}

TEST_F(DesignFields, OfAProgramByRowsAndFromVtp) {
    folder.write("cp.csv", rows());
    fs::create_directory(folder / "heat");
    Eigen::VectorXd heat = Eigen::VectorXd::LinSpaced(vertices(), 0, 1);
    write_vtp(folder / "heat/out.vtp", problem.surface, {{"q", heat}});
    folder.write("result.json", R"({"values": {"drag": 1}, "fields": {"cp": "cp.csv"}})");
    folder.write("heat/result.json", R"({"value": 1, "fields": {"heat": {"file": "out.vtp", "field": "q"}}})");
    const std::vector<Field> found = fields();
    ASSERT_EQ(found.size(), 2U);
    EXPECT_EQ(found[0].name, "cp");
    EXPECT_EQ(std::get<Eigen::VectorXd>(found[0].values)[7], 3.5);
    EXPECT_EQ(found[1].name, "heat");
    EXPECT_EQ(std::get<Eigen::VectorXd>(found[1].values), heat);
    EXPECT_TRUE(problems.empty());
}

TEST_F(DesignFields, WhatIsNoFieldIsOmittedAndNamed) {
    const std::string cp = "\"cp\": \"cp.csv\"", good = rows();
    EXPECT_NE(problem_of(cp, "0,1\n1,nan\n").find("line 2: expected index,value"), std::string::npos);
    EXPECT_NE(problem_of(cp, "0,1\n0,1\n").find("line 2: vertex 0 appears twice"), std::string::npos);
    EXPECT_NE(problem_of(cp, "0,1\n-1,1\n").find("index -1, limits 0"), std::string::npos);
    EXPECT_NE(problem_of(cp, "0,1\n1.5,1\n").find("index 1.5"), std::string::npos);
    EXPECT_NE(problem_of(cp, "0,1\n1e300,1\n").find("limits 0"), std::string::npos);
    EXPECT_NE(problem_of(cp, "0,1\n").find("1 rows, must be"), std::string::npos);
    EXPECT_NE(problem_of(cp, "").find("0 rows"), std::string::npos);
    EXPECT_NE(problem_of("\"cp\": \"../cp.csv\"", good).find("in the folder"), std::string::npos);
    EXPECT_NE(problem_of("\"cp\": \"/etc/passwd\"", good).find("in the folder"), std::string::npos);
    EXPECT_NE(problem_of("\"cp\": \"missing.csv\"", good).find("missing.csv"), std::string::npos);
    EXPECT_NE(problem_of("\"cp\": 7", good).find("must be the name of a file"), std::string::npos);
    EXPECT_NE(problem_of("\"load\": \"cp.csv\"", good).find("the name is taken"), std::string::npos);
}

TEST_F(DesignFields, OtherFilesAreNoConcernOfTheirs) {
    EXPECT_TRUE(fields().empty());
    for (const char* text : {"", "[1]", "{\"fields\": 3}", "{\"value\": 1}", "{\"fields\": {}"}) {
        folder.write("result.json", text);
        EXPECT_TRUE(fields().empty()) << text;
    }
    EXPECT_TRUE(problems.empty());
}

TEST_F(DesignFields, OfBuiltInQuantitiesAtTheDesignsParameters) {
    Quantity aero;
    aero.names = {"aero.drag"};
    aero.fields = [](const QuantityRequest& request) {
        return std::vector<SurfaceField>{{"aero.cp", request.parameters.at(0).second * request.surface.vertices.col(0)},
                                         {"short", Eigen::VectorXd::Zero(1)},
                                         {"bad", Eigen::VectorXd::Constant(request.surface.num_vertices(), NAN)}};
    };
    Quantity broken;
    broken.names = {"broken"};
    broken.fields = [](const QuantityRequest&) -> std::vector<SurfaceField> { throw InvalidInput("no such flow"); };
    problem.quantities = {aero, broken};
    const std::vector<Field> found =
        design_fields(problem, {problem.surface, folder.path(), {{"alpha", 3.0}}, {}}, problems);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].name, "aero.cp");
    EXPECT_EQ(std::get<Eigen::VectorXd>(found[0].values), Eigen::VectorXd(3 * problem.surface.vertices.col(0)));
    ASSERT_EQ(problems.size(), 3U);
    EXPECT_NE(problems[2].find("fields of broken are ignored: no such flow"), std::string::npos);
}

TEST_F(DesignFields, OfAFolderThatHasGoneAreThoseOfTheDataSet) {
    const Eigen::VectorXd cp = Eigen::VectorXd::LinSpaced(vertices(), 0, 1), other = 2 * cp;
    write_vtp(folder / "design.vtp", problem.surface,
              {{"cp", cp}, {"load", other}, {"displacement", problem.surface.vertices}});
    const fs::path gone = folder / "evaluations/000003";
    const auto shown = [&](const fs::path& data_set) {
        return design_fields(problem, {problem.surface, gone, {}, data_set}, problems);
    };
    ASSERT_EQ(shown(folder / "design.vtp").size(), 1U);
    EXPECT_EQ(std::get<Eigen::VectorXd>(shown(folder / "design.vtp")[0].values), cp);
    EXPECT_TRUE(shown(folder / "none.vtp").empty());
    EXPECT_TRUE(problems.empty());
    folder.write("bad.vtp", "<VTKFile>");
    EXPECT_TRUE(shown(folder / "bad.vtp").empty());
    EXPECT_EQ(problems.size(), 1U);
    fs::create_directories(gone);  // it is there: what it says counts
    EXPECT_TRUE(shown(folder / "design.vtp").empty());
}

}  // namespace
}  // namespace strake
