#include "core/mesh/surface_map.hpp"
#include "external_fixture.hpp"
#include "objectives/external/hand_over.hpp"

#include <nlohmann/json.hpp>

/// Gradients of a program of their own, and of points of the program's own.
using namespace strake;

class GradientCommand : public ExternalTest {
protected:
    ExternalCommand separate(const std::string& role = "gradients") const {
        ExternalCommand command = fake("values_only");
        command.gradient_command = {FAKE_SOLVER, role, "{request}", "{result}"};
        return command;
    }
    QuantityRequest request(bool sensitivities) const { return {mesh, sensitivities, 1, 2, {{"tip.load_x", -2}}}; }
    std::filesystem::path first() const { return folder / "evaluations/000001"; }
};

TEST_F(GradientCommand, RunsOnlyWhenGradientsAreWanted) {
    const QuantityResult values = ask(separate(), false);
    ASSERT_FALSE(values.failure) << values.failure->message;
    EXPECT_TRUE(values.dJ_dv.empty());
    EXPECT_FALSE(std::filesystem::exists(first() / "gradient_request.json"));
    const QuantityResult both = ask(separate(), true, 2);
    ASSERT_FALSE(both.failure) << both.failure->message;
    EXPECT_EQ(both.dJ_dv.at(0), Points::Ones(mesh.num_vertices(), 3));
    EXPECT_NEAR(both.values.at(0), mesh.vertices.sum(), 1e-12);
}

TEST_F(GradientCommand, RunsLaterInTheFolderOfTheValues) {
    const Quantity quantity = external(separate());
    ASSERT_TRUE(quantity.differentiate);
    ASSERT_FALSE(quantity.evaluate(request(false)).failure);
    const QuantityResult gradients = quantity.differentiate(request(true));
    ASSERT_FALSE(gradients.failure) << gradients.failure->message;
    EXPECT_EQ(gradients.dJ_dv.at(0), Points::Ones(mesh.num_vertices(), 3));
    EXPECT_TRUE(gradients.values.empty());
    for (const char* name :
         {"result.json", "gradient.json", "gradient_request.json", "gradient-stdout.log", "stdout.log"})
        EXPECT_TRUE(std::filesystem::exists(first() / name)) << name;
    EXPECT_FALSE(external(fake("ok")).differentiate);
}

TEST_F(GradientCommand, AnotherStartFindsTheFolderOrMakesItAgain) {
    ASSERT_FALSE(external(separate()).evaluate(request(false)).failure);
    EXPECT_FALSE(external(separate()).differentiate(request(true)).failure);
    EXPECT_FALSE(external(separate()).differentiate(request(true)).failure) << "with files of its own: gradient-2.json";
    EXPECT_TRUE(std::filesystem::exists(first() / "gradient-2.json"));
    std::filesystem::remove_all(folder / "evaluations");
    const QuantityResult again = external(separate()).differentiate(request(true));
    ASSERT_FALSE(again.failure) << again.failure->message;
    EXPECT_TRUE(has(again.remarks.at(0), "is gone: the command runs again"));
    TriMesh moved = mesh;
    moved.vertices *= 1.5;
    ExternalCommand follows = separate();
    follows.may_follow_others = true;
    const QuantityResult other = external(follows).differentiate({moved, true, 1, 2, {}});
    ASSERT_FALSE(other.failure);
    EXPECT_TRUE(std::filesystem::exists(folder / "evaluations/000001-2")) << "the folder there is of another surface";
}

TEST_F(GradientCommand, FailsLikeTheCommand) {
    const auto failure = [&](ExternalCommand command, int evaluation) {
        const QuantityResult result = ask(command, true, evaluation);
        return result.failure ? result.failure->kind + ": " + result.failure->message : "";
    };
    const std::string exit = failure(separate("exit_3"), 1);
    EXPECT_TRUE(has(exit, "exit: aero, evaluation 1: gradient: exit status 3") && has(exit, "diverged")) << exit;
    EXPECT_TRUE(has(failure(separate("no_result"), 2), "no_result: "));
    EXPECT_TRUE(has(failure(separate("values_only"), 3), "exit: "));
    ExternalCommand slow = separate("hang");
    slow.gradient_timeout_s = 0.3;
    slow.grace_s = 0.2;
    EXPECT_TRUE(has(failure(slow, 4), "timeout: "));
    ExternalCommand flaky = separate("flaky_gradients");
    EXPECT_TRUE(has(failure(flaky, 5), "exit: "));
    flaky.retries = 1;
    flaky.pause_s = 0;
    const QuantityResult result = ask(flaky, true, 6);
    ASSERT_FALSE(result.failure) << result.failure->message;
    EXPECT_EQ(result.remarks.size(), 1u);
    ExternalCommand missing = separate();
    missing.gradient_command[0] = "./nowhere";
    ASSERT_TRUE(check_program(missing));
    EXPECT_TRUE(has(check_program(missing)->message, "aero (gradient_command): program"))
        << check_program(missing)->message;
}

class ProgramPointsTest : public ExternalTest {
protected:
    ExternalCommand with_points(bool numbered) const {
        ExternalCommand command = fake("at_points");
        NumberedPoints rest{0.7 * mesh.vertices.topRows(30)};
        rest.at.row(0) = mesh.vertices.row(7);
        for (int i = 0; numbered && i < 30; ++i) rest.ids.push_back(1000 - 3 * i);
        SurfaceMap map(mesh, rest.at);
        command.points = std::make_shared<const ProgramPoints>(ProgramPoints{rest, std::move(map), false});
        return command;
    }
};

TEST_F(ProgramPointsTest, MoveAndTheirGradientsComeBack) {
    int evaluation = 0;
    for (const bool numbered : {false, true}) {
        const ExternalCommand command = with_points(numbered);
        TriMesh moved = mesh;
        moved.vertices.col(2) *= 1.1;
        const Quantity quantity = external(command);
        const auto value = [&](const TriMesh& surface, bool gradients) {
            const QuantityResult result = quantity.evaluate({surface, gradients, ++evaluation, 1, {}});
            EXPECT_FALSE(result.failure) << result.failure->message;
            return result;
        };
        const QuantityResult at = value(moved, true);
        EXPECT_NEAR(at.values[0], command.points->map.moved(moved.vertices).sum(), 1e-9);
        Points d = Points::Random(mesh.num_vertices(), 3);
        const double slope = at.dJ_dv[0].cwiseProduct(d).sum();
        EXPECT_NEAR(value(with_vertices(moved, moved.vertices + d), false).values[0] - at.values[0], slope, 1e-9);
        EXPECT_GT(std::abs(slope), 1e-3);
    }
    const auto request = nlohmann::json::parse(contents(folder / "evaluations/000001/request.json"));
    EXPECT_EQ(request["points"], "points.csv");
    EXPECT_EQ(request["num_points"], 30);
}

TEST_F(ProgramPointsTest, Su2ListsThemUnderTheirOwnNumbers) {
    const ExternalCommand command = with_points(true);
    const std::string rows = handed_over_bytes(mesh, "su2-positions", command.points.get());
    EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 30);
    EXPECT_EQ(rows.find("1000 "), 0u);
    double id = 0;
    Eigen::Vector3d x;
    std::istringstream(rows) >> id >> x[0] >> x[1] >> x[2];
    EXPECT_EQ(x, mesh.vertices.row(7).transpose()) << "read back to the last bit";
    EXPECT_NE(rows.find("\n997 "), std::string::npos);
    const std::string vertices = handed_over_bytes(mesh, "su2-positions", nullptr);
    EXPECT_EQ(vertices.find("0 "), 0u);
    EXPECT_EQ(std::count(vertices.begin(), vertices.end(), '\n'), mesh.num_vertices());
}

TEST_F(ExternalTest, EveryFormatIsHandedOver) {
    int evaluation = 0;
    for (const char* format : {"stl", "stl-ascii", "obj", "ply", "ply-ascii", "off", "tri", "vtp", "su2-positions"}) {
        ExternalCommand command = fake("ok");
        command.command = {"sh", "-c", "cp \"$0\" handed && echo '{\"value\": 1}' > result.json", "{surface}"};
        command.format = format;
        const QuantityResult result = ask(command, false, ++evaluation);
        ASSERT_FALSE(result.failure) << format << result.failure->message;
        const auto call = folder / "evaluations" / ("00000" + std::to_string(evaluation));
        EXPECT_EQ(contents(call / "handed"), handed_over_bytes(mesh, format, nullptr)) << format;
    }
    ExternalCommand wrong = fake("ok");
    wrong.format = "step";
    EXPECT_THROW(external(wrong), std::invalid_argument);
}
