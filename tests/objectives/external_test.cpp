#include "objectives/external/external.hpp"

#include "core/error.hpp"
#include "external_fixture.hpp"
#include "objectives/geometry/measures.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <nlohmann/json.hpp>

using namespace strake;
using External = ExternalTest;

TEST_F(External, GivesTheValueAndTheGradient) {
    for (const char* role : {"ok", "coordinates", "deletes_surface", "damages_surface"}) {
        ExternalCommand command = fake(role);
        command.evaluations_dir = folder / role;
        const Points before = mesh.vertices;
        const QuantityResult result = ask(command, true);
        ASSERT_FALSE(result.failure) << role << ": " << result.failure->message;
        EXPECT_NEAR(result.values.at(0), mesh.vertices.sum(), 1e-12);
        EXPECT_EQ(result.dJ_dv.at(0), Points::Ones(mesh.num_vertices(), 3)) << role;
        EXPECT_EQ(before, mesh.vertices);
    }
}

TEST_F(External, CoordinatesOfAWeldedStlFindTheirVertices) {
    // STL repeats each vertex and rounds it to float; the program welds, and answers once per vertex.
    ExternalCommand command = fake("unused");
    command.format = "stl-ascii";
    command.command = {"sh", "-c",
                       "grep vertex \"$0\" | awk '{print $2\",\"$3\",\"$4\",1,2,3\"}' | sort -u > gradient.csv; "
                       "echo '{\"value\": 1, \"gradient\": \"gradient.csv\"}' > \"$1\"",
                       "{surface}", "{result}"};
    const QuantityResult result = ask(command, true);
    ASSERT_FALSE(result.failure) << result.failure->message;
    EXPECT_EQ(result.dJ_dv.at(0).row(5), Eigen::RowVector3d(1, 2, 3));
}

TEST_F(External, SeveralValuesAreNamedAndOthersLeftAlone) {
    ExternalCommand command = fake("two_values");
    command.outputs = {"drag", "lift"};
    EXPECT_EQ(external(command).names, (std::vector<std::string>{"aero.drag", "aero.lift"}));
    const QuantityResult result = ask(command, true);
    ASSERT_FALSE(result.failure) << result.failure->message;
    EXPECT_EQ(result.values, (std::vector<double>{1.5, -0.5}));
    EXPECT_EQ(result.dJ_dv.at(0), Points::Ones(mesh.num_vertices(), 3));
    EXPECT_EQ(result.dJ_dv.at(1), 2 * Points::Ones(mesh.num_vertices(), 3));
}

TEST_F(External, OneNamedValueMayUseTheShortForm) {
    ExternalCommand command = fake("ok");
    EXPECT_EQ(external(command).names, std::vector<std::string>{"aero"});
    command.outputs = {"drag"};
    EXPECT_EQ(external(command).names, std::vector<std::string>{"aero.drag"});
    EXPECT_FALSE(ask(command, true, 1).failure);
    command.outputs = {"drag", "lift"};
    const QuantityResult result = ask(command, true, 2);
    ASSERT_TRUE(result.failure);
    EXPECT_EQ(result.failure->kind, "missing_key");
    EXPECT_TRUE(has(result.failure->message, "for a command that outputs one value")) << result.failure->message;
}

TEST_F(External, EachEvaluationHasAFreshNumberedFolder) {
    const ExternalCommand command = fake("ok");
    EXPECT_FALSE(ask(command, false, 12).failure);
    for (const char* file : {"surface.obj", "request.json", "result.json", "stdout.log", "stderr.log"})
        EXPECT_TRUE(std::filesystem::exists(folder / "evaluations/000012" / file)) << file;
    EXPECT_THROW(ask(command, false, 12), OutputError);
    EXPECT_FALSE(ask(command, false, 13).failure);
}

TEST_F(External, ProgramSeesItsRequestAndNothingOfOurs) {
    const int leak = ::open("/dev/null", O_RDONLY);  // without CLOEXEC, as libraries do
    const QuantityResult result = ask(fake("environment"), true);
    ::close(leak);
    ASSERT_FALSE(result.failure) << result.failure->message;
    const auto home = folder / "evaluations/000001";
    const auto seen = nlohmann::json::parse(contents(home / "seen.json"));
    EXPECT_EQ(seen["cwd"], std::filesystem::canonical(home).string());
    EXPECT_EQ(seen["stdin"], "/dev/null");
    EXPECT_EQ(seen["descriptors"], nlohmann::json::array()) << seen["descriptors"];
    EXPECT_TRUE(seen["leads_group"].get<bool>() && seen["leads_session"].get<bool>());
    const auto& request = seen["request"];
    EXPECT_EQ(request["quantity"], "aero");
    EXPECT_EQ(request["evaluation"], 1);
    EXPECT_EQ(request["level"], 2);
    EXPECT_EQ(request["surface"], "surface.obj");
    EXPECT_EQ(request["variables"], (nlohmann::json{{"alpha", 0.05}, {"tip.load_x", -2.0}}));
    EXPECT_EQ(request["wanted"]["gradients"], nlohmann::json::array({"value"}));
    EXPECT_EQ(request["units"]["length"], "mm");
}

TEST_F(External, GradientsAreAskedForOnlyWhenWanted) {
    ExternalCommand command = fake("environment");
    EXPECT_TRUE(ask(command, false, 1).dJ_dv.empty());
    command.has_gradients = false;
    EXPECT_TRUE(ask(command, true, 2).dJ_dv.empty());
    for (const char* number : {"000001", "000002"}) {
        const auto request = nlohmann::json::parse(contents(folder / "evaluations" / number / "request.json"));
        EXPECT_EQ(request["wanted"]["gradients"], nlohmann::json::array());
    }
}

TEST_F(External, EveryWrongResultIsAFailureOfItsKind) {
    struct Case {
        const char *role, *kind, *words;
    };
    const Case cases[] = {
        {"no_result", "no_result", "'result.json' was not written"},
        {"no_result", "no_result", "nothing to say"},  // the program's last lines
        {"empty", "unreadable", "empty"},
        {"truncated", "unreadable", "result.json:3:"},
        {"nan_literal", "not_finite", "result.json:1:11: 'NaN'"},
        {"minus_infinity", "not_finite", "result.json:2:3: 'Infinity'"},
        {"overflow", "not_finite", "result.json:1:11: number 1e400"},
        {"string", "wrong_type", "'value' is string \"1.0\", must be a number"},
        {"array", "wrong_type", "must be an object"},
        {"deep", "unreadable", "nested deeper"},
        {"missing_key", "missing_key", "did you mean 'value'?"},
        {"key_twice", "unreadable", "has the key 'value' twice"},
        {"both_forms", "wrong_type", "both"},
        {"no_gradient", "missing_key", "no 'gradient'"},
        {"bad_variables", "wrong_type", "variables.drag"},
        {"utf16", "unreadable", "UTF-16"},
        {"binary", "unreadable", "not text"},
        {"huge", "unreadable", "limit"},
        {"directory", "unreadable", "is a directory"},
        {"fifo", "unreadable", "is a FIFO"},
        {"link", "unreadable", "is a link"},
        {"deletes_folder", "no_result", "folder is gone"},
        {"gradient_short", "wrong_count", "161 rows, the surface has 162 vertices"},
        {"gradient_short", "wrong_count", "first without: 161"},
        {"gradient_twice", "wrong_count", "gradient.csv:163: vertex 0 appears twice, first in line 1"},
        {"gradient_nan", "not_finite", "gradient.csv:3: column 3: 'nan'"},
        {"gradient_columns", "unreadable", "gradient.csv:3: 3 columns, expected 4"},
        {"gradient_word", "unreadable", "gradient.csv:3: column 3: 'one' is not a number"},
        {"gradient_index", "wrong_count", "vertex index 162 must be in 0..161"},
        {"gradient_far", "wrong_count", "no vertex within 1e-5"},
        {"gradient_missing", "no_result", "'gradient.csv' was not written"},
        {"gradient_outside", "unreadable", "stay in it"},
        {"gradient_absolute", "unreadable", "stay in it"},
        {"gradient_number", "wrong_type", "must be the name of a file"},
    };
    int evaluation = 0;
    for (const Case& c : cases) {
        const QuantityResult result = ask(fake(c.role), true, ++evaluation);
        ASSERT_TRUE(result.failure) << c.role;
        EXPECT_EQ(result.failure->kind, c.kind) << c.role << ": " << result.failure->message;
        EXPECT_TRUE(has(result.failure->message, c.words)) << c.role << ": " << result.failure->message;
        EXPECT_TRUE(has(result.failure->message, text("aero, evaluation ", evaluation))) << result.failure->message;
        EXPECT_TRUE(result.values.empty() && result.dJ_dv.empty()) << c.role;
    }
}

TEST_F(External, BuiltInVolumeAndTheExampleScriptAgree) {
    ExternalCommand command = fake("unused");
    command.command = {"./volume.py", "{request}", "{result}"};
    command.case_dir = EXAMPLE_DIR;
    ASSERT_FALSE(check_program(command));
    mesh = ellipsoid({1, 2, 0.5}, 3);
    mesh.vertices.rowwise() += Eigen::RowVector3d(0.3, -0.2, 0.1);
    command.diagonal = box_diagonal(mesh);
    const QuantityResult theirs = ask(command, true), ours = volume(mesh).evaluate({mesh, true, 1, 0, {}});
    ASSERT_FALSE(theirs.failure) << theirs.failure->message;
    // Bit for bit: the same sums in the same order, and 17 digits both ways.
    EXPECT_EQ(theirs.values.at(0), ours.values.at(0));
    EXPECT_EQ(theirs.dJ_dv.at(0), ours.dJ_dv.at(0));
}

TEST_F(External, ExampleScriptAgreesOnAHalfModelToo) {
    ExternalCommand command = fake("unused");
    command.command = {"./volume.py", "{request}", "{result}"};
    command.case_dir = EXAMPLE_DIR;
    mesh = strip(1, 1, 4, 4);  // a bulge over z = 0 whose rim lies in that plane
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const double x = mesh.vertices(v, 0), y = mesh.vertices(v, 1);
        mesh.vertices(v, 2) = x * (1 - x) * y * (1 - y) * (1 + x + y);
    }
    const Quantity built_in = volume(mesh, SymmetryPlane{Eigen::Vector3d::UnitZ(), 0});
    const QuantityResult theirs = ask(command, true), ours = built_in.evaluate({mesh, true, 1, 0, {}});
    ASSERT_FALSE(theirs.failure) << theirs.failure->message;
    EXPECT_EQ(theirs.values.at(0), ours.values.at(0));
    for (int v = 0; v < mesh.num_vertices(); ++v)  // on the plane they differ across it, where nothing can move
        for (int c = 0; c < (mesh.vertices(v, 2) == 0 ? 2 : 3); ++c)
            EXPECT_EQ(theirs.dJ_dv.at(0)(v, c), ours.dJ_dv.at(0)(v, c));
}

TEST_F(External, WrongOptionsAreRefused) {
    const auto refused = [](const ExternalCommand& command, const std::string& words) {
        try {
            external(command);
            ADD_FAILURE() << "accepted: " << words;
        } catch (const InvalidInput& error) {
            EXPECT_TRUE(has(error.what(), words)) << error.what();
        }
    };
    ExternalCommand command = fake("ok");
    command.command = {};
    refused(command, "command is empty");
    command = fake("ok");
    command.timeout_s = 0;
    refused(command, "timeout = 0 s must be > 0");
    command = fake("ok");
    command.grace_s = -1;
    refused(command, "grace");
    command = fake("ok");
    command.diagonal = 0;
    refused(command, "diagonal");
    command = fake("ok");
    command.outputs = {"drag", "drag"};
    refused(command, "drag");
    command = fake("ok");
    command.command.push_back("--in={sruface}");
    refused(command, "did you mean {surface}?");
    command = fake("ok");
    command.format = "step";
    EXPECT_THROW(external(command), InvalidInput);
    command = fake("ok");
    command.command.push_back("{print $1} {x}");  // other programs' braces
    EXPECT_NO_THROW(external(command));
    EXPECT_THROW(ask(fake("ok"), false, -1), InvalidInput);
}

TEST_F(External, SurfaceThatIsNotFiniteIsNeverHandedOver) {
    mesh.vertices(3, 1) = std::numeric_limits<double>::quiet_NaN();
    const QuantityResult result = ask(fake("ok"));
    ASSERT_TRUE(result.failure);
    EXPECT_EQ(result.failure->kind, "undefined");
    EXPECT_FALSE(std::filesystem::exists(folder / "evaluations"));
}

TEST_F(External, FolderThatCannotBeMadeIsAnOutputError) {
    ExternalCommand command = fake("ok");
    std::ofstream(folder / "file") << "in the way";
    command.evaluations_dir = folder / "file" / "evaluations";
    EXPECT_THROW(ask(command), OutputError);
}
