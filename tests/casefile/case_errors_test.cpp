#include "casefile/load_case.hpp"
#include "casefile/model/case.hpp"
#include "casefile/read/resolved_case.hpp"
#include "casefile/yaml/value.hpp"
#include "tests/casefile/folder.hpp"

#include <gtest/gtest.h>
#include <chrono>

namespace strake {
namespace {

const char* valid = R"(case: wing
surface: {file: wing.obj, units: mm}
regions:
  root: {box: [[-1, -1, -1], [1, 0.01, 1]]}
  tip:  {plane: {normal: [0, 1, 0], at: 0.5}, side: above}
  flap: {triangles: flap.txt}
fixed: [root]
symmetry: {plane: y, at: 0}
shell: {thickness: {default: 2%, root: 4%}, spring: 0}
loads:
  - {region: tip, traction: [0.0, 0.0, 0.001]}
strains:
  - {region: flap, translate: [0, 0, 0.1], rotate: [0deg, 5deg, 0deg]}
parameters: {levels: [20deg, 10deg], variables: [load], max_displacement: 5%}
quantities:
  match: {type: target_shape, file: wing.obj, match: same}
objective: {minimize: match}
constraints:
  volume: {min: 1.0, relative: true}
optimize: {method: sqp, budget: {evaluations: 200}}
)";

class CaseErrors : public testing::Test {
protected:
    Folder folder;
    CaseErrors() {
        folder.write("wing.obj", tetrahedron_obj);
        folder.write("flap.txt", "0\n");
        folder.write("lines.csv", "0.2,0.2,0.1,0,0,1\n0.1,0.1,0.1,0,0,1\n");
        folder.write("wanted.csv", "0.2,0.2,0.1,0,0,1,0.6\n");
        folder.write("words.csv", "0.2,0.2,0.1,0,0,1\n0.1,x,0.1,0,0,1\n");
    }
    std::string file(const std::string& yaml) { return folder.write("case.yaml", yaml).string(); }
    /// The lines of the error, with the folder cut away; empty for a case without errors.
    std::string errors(const std::string& yaml, Purpose purpose = Purpose::any) {
        const std::string path = file(yaml);
        try {
            load_case(path, purpose);
            return "";
        } catch (const CaseError& e) {
            std::string all = e.what();
            const std::string prefix = folder.path().string() + "/";
            for (std::size_t at; (at = all.find(prefix)) != std::string::npos;) all.erase(at, prefix.size());
            return all;
        }
    }
    static std::string with(const std::string& from, const std::string& to) {
        std::string yaml = valid;
        const std::size_t at = yaml.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return yaml.replace(at, from.size(), to);
    }
};

TEST_F(CaseErrors, TheValidCaseHasNone) { EXPECT_EQ(errors(valid), ""); }

struct Broken {
    const char *from, *to, *message;
};

const Broken broken[] = {
    {"min: 1.0", "mim: 1.0",
     "case.yaml:19:3: constraints.volume must have min, max or equals\n"
     "case.yaml:19:12: unknown key 'mim' in constraints.volume; did you mean 'min'?"},
    {"[20deg, 10deg]", "[20deg, 190deg]", "case.yaml:14:30: parameters.levels[1] = 190deg must be in (0deg, 90deg]"},
    {"[20deg, 10deg]", "[20deg, 30deg]",
     "case.yaml:14:30: parameters.levels[1] = 30deg must be < parameters.levels[0] = 20deg"},
    {"[20deg, 10deg]", "[20, 10deg]",
     "case.yaml:14:23: parameters.levels[0] = 20 must be an angle with a unit, for example 5deg or 0.1rad"},
    {"fixed: [root]", "fixed: [root, tpi]",
     "case.yaml:7:15: region 'tpi' is not declared; did you mean 'tip'? Regions: root, tip, flap"},
    {"fixed: [root]", "fixed: root", "case.yaml:7:8: fixed must be a list, got 'root'; write [root]"},
    {"fixed: [root]", "fixed: root of/{both}",
     "case.yaml:7:8: fixed must be a list, got 'root of/{both}'; write [root, \"of/{both}\"]"},
    {"fixed: [root]", "fixed: root, tip", "case.yaml:7:8: fixed must be a list, got 'root, tip'; write [root, tip]"},
    {"fixed: [root]", "fixed: root,tip", "case.yaml:7:8: fixed must be a list, got 'root,tip'; write [root, tip]"},
    {"fixed: [root]", "fixed: sh -c 'a 1,2' it's",
     "case.yaml:7:8: fixed must be a list, got 'sh -c 'a 1,2' it's'; write [sh, -c, \"a 1,2\", \"it's\"]"},
    {"fixed: [root]", "fixed: a \"\" 'say \"b\"'",
     "case.yaml:7:8: fixed must be a list, got 'a \"\" 'say \"b\"''; write [a, \"\", 'say \"b\"']"},
    {"fixed: [root]", "fixed: ''", "case.yaml:7:8: fixed must be a list, got ''"},
    {"fixed: [root]", "fixed: [root, tip]",
     "case.yaml:11:14: region 'tip' is under loads and under fixed; a held region cannot be loaded"},
    {"region: flap", "region: tip",
     "case.yaml:11:14: region 'tip' is under loads and under strains; a held region cannot be loaded"},
    {"fixed: [root]", "fixed: [flap]", "case.yaml:13:14: region 'flap' is under fixed and under strains; choose one"},
    {"default: 2%", "default: 0", "case.yaml:9:30: shell.thickness.default = 0 must be > 0"},
    {"spring: 0}", "spring: -1}", "case.yaml:9:53: shell.spring = -1 must be >= 0"},
    {"default: 2%", "default: -5%", "case.yaml:9:30: shell.thickness.default = -5% must be > 0"},
    {"method: sqp, budget: {evaluations: 200}}", "method: sqp}\noutput: {keep: faild}",
     "case.yaml:21:16: output.keep = faild must be one of all, failed, best, none; did you mean 'failed'?"},
    {"root: 4%", "roto: 4%",
     "case.yaml:9:34: region 'roto' is not declared; did you mean 'root'? Regions: root, tip, flap"},
    {"file: wing.obj, units", "file: wnig.obj, units",
     "case.yaml:2:17: surface.file = wnig.obj does not exist (wnig.obj); did you mean 'wing.obj'?"},
    {"flap.txt", "falp.txt",
     "case.yaml:6:21: regions.flap.triangles = falp.txt does not exist (falp.txt); did you mean 'flap.txt'?"},
    {"{minimize: match}", "{minimize: mach}",
     "case.yaml:17:23: quantity 'mach' is not known; did you mean 'match'? Quantities: match, volume, area"},
    {"{minimize: match}", "{minimize: match, maximize: volume}",
     "case.yaml:17:12: objective must have exactly one of minimize, maximize"},
    {"min: 1.0,", "min: 2, max: 1,", "case.yaml:19:17: constraints.volume.min = 2 must be <= max = 1"},
    {"method: sqp", "method: SLQSP",
     "case.yaml:20:20: optimize.method = SLQSP must be one of auto, sqp, mma, ccsaq, lbfgs, tnewton, var2, "
     "nlopt_slsqp, "
     "model, cobyla, bobyqa, "
     "neldermead, sbplx, praxis, crs2, isres, mlsl, direct, esch; did you mean 'sqp'?"},
    {"evaluations: 200", "evaluations: 5.7", "case.yaml:20:47: optimize.budget.evaluations = 5.7 must be an integer"},
    {"evaluations: 200", "evaluations: -1", "case.yaml:20:47: optimize.budget.evaluations = -1 must be >= 1"},
    {"variables: [load]", "variables: []",
     "case.yaml:14:49: parameters.variables is empty: nothing can change (it may be empty if the case has "
     "parameters.fields, parameters.planform, parameters.given or variables)"},
    {"variables: [load]", "variables: [laod]",
     "case.yaml:14:50: parameters.variables[0] = laod must be one of load, normal, strain, strain_rotation, "
     "strain_translation, stiffness; did you mean 'load'?"},
    {"spring: 0}", "spring: 010}", "case.yaml:9:53: shell.spring = 010 must be written without leading zeros"},
    {"spring: 0}", "solver: sparse}", "case.yaml:9:53: shell.solver = sparse must be one of auto, direct, multigrid"},
    {"case: wing", "case: wing\nrepair: {weld: -1e-6}", "case.yaml:2:16: repair.weld = -1e-6 must be >= 0"},
    {"case: wing", "case: wing\ncase: body", "case.yaml:2:1: key 'case' given twice (first on line 1)"},
    {"case: wing", "case: 'wi ng'", "case.yaml:1:7: case = wi ng must be a name of letters, digits, '_' and '-'"},
    {"case: wing", "case:", "case.yaml:1:1: case has no value; it must be a name"},
    {"at: 0.5}, side: above", "at: 0.5}", "case.yaml:5:9: regions.tip.side is missing"},
    {"[0, 1, 0], at", "[0, 1], at", "case.yaml:5:26: regions.tip.plane.normal must have 3 entries, got 2"},
    {"[0, 1, 0], at", "[0, 0, 0], at", "case.yaml:5:26: regions.tip.plane.normal = [0, 0, 0] has no direction"},
    {"[[-1, -1, -1], [1, 0.01, 1]]", "[[1, -1, -1], [-1, 0.01, 1]]",
     "case.yaml:4:29: regions.root.box[1][0] = -1 must be >= box[0][0] = 1"},
    {"traction: [0.0, 0.0, 0.001]", "traction: [0, 0, 1], force: [0, 0, 1]",
     "case.yaml:11:5: a load must have only one of traction, force"},
    {"traction: [0.0, 0.0, 0.001]", "displacement: 5%", "case.yaml:11:5: loads[0].direction is missing"},
    {"traction: [0.0, 0.0, 0.001]", "traction: [0, 0, 1], direction: [0, 0, 1]",
     "case.yaml:11:40: loads[0].direction is only allowed with 'displacement'"},
    {"match: same", "match: same, timeout: 1h",
     "case.yaml:16:60: quantities.match.timeout is only allowed with 'command'"},
    {"levels: [20deg, 10deg]", "levels: auto, min_patch: 1%",
     "case.yaml:14:28: parameters.min_patch is only allowed with a list of 'levels'"},
    {"variables: [load]", "variables: [strain, strain_rotation]",
     "case.yaml:14:49: parameters.variables: strain contains strain_rotation; use one of them"},
    {"variables: [load]", "variables: [load], free_border: 10%",
     "case.yaml:14:57: parameters.free_border is only allowed with 'variables: [strain or strain_rotation or "
     "strain_translation]'"},
    {"variables: [load]", "variables: [strain], free_border: 100%",
     "case.yaml:14:72: parameters.free_border = 100% must be in (0%, 100%)"},
    {"variables: [load]", "variables: [strain], directions: [[0, 0, 1]]",
     "case.yaml:14:59: parameters.directions is only allowed with 'variables: [load]'"},
    {"variables: [load]", "directions: [[0, 0, 1], [0, 1, 0], [0, 2, 3]]",
     "case.yaml:14:50: parameters.directions: 3 directions that are linearly dependent; give at most 3 independent "
     "ones"},
    {"variables: [load]", "directions: [[0, 0, 0]]",
     "case.yaml:14:51: parameters.directions[0] = [0, 0, 0] has no direction"},
    {"variables: [load]", "marking_fraction: 50%",
     "case.yaml:14:38: parameters.marking_fraction is only allowed with 'split: sensitivity or gradient'"},
    {"variables: [load]", "split: sensitivity, marking_fraction: 0%",
     "case.yaml:14:76: parameters.marking_fraction = 0% must be in (0%, 100%]"},
    {"variables: [load]", "split: gradient, max_variable_ratio: 1",
     "case.yaml:14:75: parameters.max_variable_ratio = 1 must be > 1"},
    {"variables: [load]", "groups: [[tip, p1], [tip]]", "case.yaml:14:59: parameters.groups names 'tip' twice"},
    {"variables: [load]", "groups: [tip]",
     "case.yaml:14:47: parameters.groups[0] must be a list, got 'tip'; write [tip]"},
    {"variables: [load]", "frozen: [tip, tip]", "case.yaml:14:52: parameters.frozen names 'tip' twice"},
    {"variables: [load]", "mirror: yes", "case.yaml:14:46: parameters.mirror = yes must be true or false"},
    {"method: sqp", "starts: 0", "case.yaml:20:20: optimize.starts = 0 must be >= 1"},
    {"method: sqp", "seed: -1", "case.yaml:20:18: optimize.seed = -1 must be >= 0"},
    {"objective: {minimize: match}\nconstraints:\n  volume: {min: 1.0, relative: true}\noptimize: {method: sqp",
     "fit: "
     "[match]\noptimize: {starts: 2",
     "case.yaml:18:12: optimize.starts is not used by fit"},
    {"{type: target_shape, file: wing.obj, match: same}", "{command: [./missing.sh]}",
     "case.yaml:16:20: quantities.match: program 'missing.sh' does not exist"},
    {"objective: {minimize: match}", "fit: [match]",
     "case.yaml:19:3: constraints are not supported together with fit\n"
     "case.yaml:20:12: optimize.method is not used by fit, which is always a least-squares fit"},
};

TEST_F(CaseErrors, EachIsNamedWithItsPlace) {
    for (const Broken& b : broken) EXPECT_EQ(errors(with(b.from, b.to)), b.message) << b.to;
}

TEST_F(CaseErrors, AllAreToldAtOnceByLine) {
    EXPECT_EQ(errors("cas: x\nsurface: {file: gone.stl}\nfixed: [a]\noptimize: {method: simplex}\n"),
              "case.yaml:1:1: unknown key 'cas'; did you mean 'case'?\n"
              "case.yaml:2:17: surface.file = gone.stl does not exist (gone.stl)\n"
              "case.yaml:3:9: region 'a' is not declared; no region is declared\n"
              "case.yaml:4:20: optimize.method = simplex must be one of auto, sqp, mma, ccsaq, lbfgs, tnewton, var2, "
              "nlopt_slsqp, model, cobyla, "
              "bobyqa, neldermead, sbplx, praxis, crs2, isres, mlsl, direct, esch");
}

TEST_F(CaseErrors, QuoteTheLine) {
    try {
        load_case(file("case: wing\nsurface: {file: wing.obj, unit: mm}\n"));
        FAIL();
    } catch (const CaseError& e) {
        EXPECT_NE(e.quoted().find("\n  2 | surface: {file: wing.obj, unit: mm}"), std::string::npos) << e.quoted();
        EXPECT_EQ(e.diagnostics.size(), 1u);
    }
}

TEST_F(CaseErrors, PurposeDecidesWhatIsMissing) {
    const std::string bare = "case: wing\nsurface: {file: wing.obj}\n";
    EXPECT_EQ(errors(bare, Purpose::deform), "");
    EXPECT_EQ(errors(bare, Purpose::any), "");
    EXPECT_EQ(errors(bare, Purpose::run),
              "case.yaml:1:1: objective is missing; add one, for example objective: {maximize: volume}");
    EXPECT_EQ(errors(bare, Purpose::fit), "case.yaml:1:1: fit is missing; add one, for example fit: [match]");
    EXPECT_EQ(errors(bare + "objective: {maximize: area}\n", Purpose::fit),
              "case.yaml:1:1: fit is missing; this is a case for 'strake run'");
    EXPECT_EQ(errors(bare + "objective: {maximize: area}\nfit: [area]\n"),
              "case.yaml:4:1: a case cannot have both objective and fit\n"
              "case.yaml:4:7: quantity 'area' has no residuals; fit needs type: target_shape or measured_points, or "
              "thickness or section_area with a target value");
    EXPECT_EQ(errors(bare + "quantities: {t: {type: target_shape, file: wing.obj}}\nfit: [t]\n"
                            "parameters: {variables: [load, stiffness]}\n"),
              "case.yaml:5:32: parameters.variables: stiffness cannot be fitted; use load, normal or strain");
    EXPECT_EQ(errors(bare + "constraints: {area: {max: 1}}\n"), "case.yaml:3:1: constraints without an objective");
}

TEST_F(CaseErrors, QuantitiesOfLinesPointsAndPlanes) {
    const auto quantity = [&](const std::string& map, const std::string& rest = "") {
        return errors("case: wing\nsurface: {file: wing.obj}\nquantities: {q: " + map + "}\n" + rest);
    };
    const std::string misspelt = quantity("{type: thicknes, at: lines.csv}");
    EXPECT_TRUE(misspelt.starts_with("case.yaml:3:24: quantities.q.type = thicknes must be one of volume, area, ") &&
                misspelt.ends_with("; did you mean 'thickness'?"))
        << misspelt;
    EXPECT_EQ(quantity("{type: thickness}"), "case.yaml:3:17: quantities.q.at is missing");
    EXPECT_EQ(quantity("{type: measured_points}"), "case.yaml:3:17: quantities.q.file is missing");
    EXPECT_EQ(quantity("{type: section_area}"), "case.yaml:3:17: quantities.q.plane is missing");
    EXPECT_EQ(quantity("{type: section_area, plane: {normal: [0, 0, 0], at: 1}}"),
              "case.yaml:3:54: quantities.q.plane.normal = [0, 0, 0] has no direction");
    EXPECT_EQ(quantity("{type: section_area, plane: {normal: [0, 0, 1], at: 5%}}").substr(0, 45),
              "case.yaml:3:69: quantities.q.plane.at = 5% mu");
    EXPECT_EQ(quantity("{type: section_area, plane: {normal: [0, 0, 1], at: 0.5}, target: 0}"),
              "case.yaml:3:83: quantities.q.target = 0 must be > 0");
    EXPECT_EQ(quantity("{type: thickness, at: lines.csv, target: 1}"),
              "case.yaml:3:50: quantities.q.target is only allowed with 'type: section_area'");
    EXPECT_EQ(quantity("{type: thickness, at: words.csv}").substr(0, 53),
              "case.yaml:3:39: quantities.q.at: words.csv:2: expecte")
        << "row of the file";
    const std::string each = "{type: thickness, at: lines.csv}";
    EXPECT_EQ(quantity(each, "objective: {maximize: q.2}\n"), "");
    EXPECT_EQ(quantity("{type: thickness, at: lines.csv, values: smallest}", "objective: {maximize: q}\n"), "");
    EXPECT_EQ(quantity(each, "objective: {maximize: q.3}\n"),
              "case.yaml:4:23: quantity 'q.3' is not known; did you mean 'q.1'? Quantities: q.1, q.2, volume, area");
}

TEST_F(CaseErrors, WhatAFitTakes) {
    const auto fitting = [&](const std::string& map, const std::string& rest) {
        return errors("case: wing\nsurface: {file: wing.obj}\nquantities: {q: " + map + "}\n" + rest);
    };
    const std::string wanted = "{type: thickness, at: wanted.csv}", lacks = " has no residuals; fit needs type: ";
    EXPECT_EQ(fitting(wanted, "fit: [q]\n"), "");
    EXPECT_EQ(fitting(wanted, "fit: [q.1]\n"),
              "case.yaml:4:7: 'q.1' is a single value; fit takes the whole quantity: write 'q'");
    EXPECT_EQ(fitting("{type: measured_points, file: lines.csv}", "fit: [q]\n"), "");
    EXPECT_EQ(fitting("{type: section_area, plane: {normal: [0, 0, 1], at: 0.5}, target: 2}", "fit: [q]\n"), "");
    for (const char* unwanted :
         {"{type: thickness, at: lines.csv}", "{type: section_area, plane: {normal: [0, 0, 1], at: 0.5}}"})
        EXPECT_EQ(fitting(unwanted, "fit: [q]\n").find("case.yaml:4:7: quantity 'q'" + lacks), 0u) << unwanted;
    EXPECT_EQ(fitting(wanted, "fit: [p]\n"), "case.yaml:4:7: quantity 'p' is not known; quantities: q.1, volume, area");
    EXPECT_EQ(fitting(wanted, "fit: [q]\noptimize: {loss_scale: 1%}\n"),
              "case.yaml:5:12: optimize.loss_scale is only allowed with 'loss: huber or cauchy or soft_l1'");
    EXPECT_EQ(
        fitting(wanted, "objective: {maximize: q.1}\noptimize: {loss: huber, loss_scale: 1%, icp_iterations: 1}\n"),
        "case.yaml:5:12: optimize.loss is used by fit only\n"
        "case.yaml:5:25: optimize.loss_scale is used by fit only\n"
        "case.yaml:5:41: optimize.icp_iterations is used by fit only");
}

TEST_F(CaseErrors, ProgramsWithoutGradientsNeedAMethodWithoutOrDifferences) {
    folder.write("p.sh", "#!/bin/sh\n");
    std::filesystem::permissions(folder.path() / "p.sh", std::filesystem::perms::owner_all);
    const std::string yaml =
        "case: wing\nsurface: {file: wing.obj}\nquantities: {aero: {command: [./p.sh], outputs: [drag, lift], "
        "gradients: "
        "false}}\nobjective: {minimize: aero.drag}\n";
    EXPECT_EQ(errors(yaml), "");  // auto
    EXPECT_EQ(errors(yaml + "optimize: {method: sqp}\n"),
              "case.yaml:4:23: 'aero.drag' has no gradients: add optimize.finite_differences: true, or a "
              "derivative-free optimize.method (model, cobyla, bobyqa, neldermead, sbplx, praxis, crs2, isres, direct, "
              "esch)");
    EXPECT_EQ(errors(yaml + "optimize: {method: sqp, finite_differences: true}\n"), "");
    EXPECT_EQ(errors(yaml + "optimize: {method: model, batch: 4}\n"), "");
    EXPECT_EQ(errors(yaml + "optimize: {batch: 0}\n"), "case.yaml:5:19: optimize.batch = 0 must be >= 1");
    EXPECT_EQ(errors(yaml + "optimize: {method: GN_CRS2_LM}\n"), "");
    EXPECT_EQ(errors(yaml + "optimize: {method: LN_COBYLA}\n"), "");
}

// --- YAML itself -----------------------------------------------------------------------------------------------------

TEST_F(CaseErrors, TrapsOfYaml) {
    const std::pair<std::string, std::string> traps[] = {
        {"a: &a {b: *a}\n",
         "case.yaml:1:11: this alias refers to a value that contains it; write the value out instead"},
        {"a: *b\n", "case.yaml:1:4: not YAML: the referenced anchor is not defined"},
        {"case: x\n---\ncase: y\n", "case.yaml:2:1: a second document starts here; a case is one document"},
        {"a: &a {b: 1}\nc: {<<: *a}\n", "case.yaml:2:5: merge keys (<<) are not supported; write the keys out"},
        {"case: !!python/object x\n",
         "case.yaml:1:7: the tag 'tag:yaml.org,2002:python/object' is not supported; write plain YAML"},
        {"? [a, b]\n: 1\n", "case.yaml:1:3: a key must be plain text"},
        {"", "case.yaml: is empty"},
        {"# nothing\n", "case.yaml: is empty"},
        {"- a\n", "case.yaml:1:1: a case must be a map of keys, for example 'case: wing'"},
        {"wing\n", "case.yaml:1:1: a case must be a map of keys, for example 'case: wing'"},
        {std::string("case: a\0b\n", 10), "case.yaml:1:8: a NUL character; a case is UTF-8 text"},
        {"\xFF\xFE"
         "c\0",
         "case.yaml:1:1: the file is UTF-16; save it as UTF-8"},
        {"case: w\xE4ng\n", "case.yaml:1:8: not UTF-8; save the file as UTF-8"},
        {"case: x\nsurface:\n\tfile: y\n", "case.yaml:3:1: this line is indented with a tab; YAML requires spaces"},
        {"case: " + std::string(70, '[') + std::string(70, ']') + "\n", "case.yaml:1:70: nested deeper than 64 levels"},
        {"case: x\n" + std::string(1000001, '#'),
         "case.yaml: is larger than 1000000 bytes; a case file holds settings, not data"},
    };
    for (const auto& [yaml, message] : traps) EXPECT_EQ(errors(yaml), message) << yaml.substr(0, 60);
}

TEST_F(CaseErrors, BillionLaughsAreCutShort) {
    std::string yaml = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
    for (int k = 1; k < 10; ++k) {
        const std::string below = text("*a", k - 1);
        yaml += text("a", k, ": &a", k, " [");
        for (int i = 0; i < 10; ++i) yaml += text(i ? ", " : "", below);
        yaml += "]\n";
    }
    const auto start = std::chrono::steady_clock::now();
    const std::string message = errors(yaml);
    EXPECT_NE(message.find("more than 100000 values once aliases are expanded"), std::string::npos) << message;
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

/// Aliases are blamed only where there are any.
TEST_F(CaseErrors, TooManyValuesWithoutAliases) {
    std::string yaml = "fixed: [x";
    for (int k = 0; k < 100001; ++k) yaml += ",x";
    const std::string message = errors(yaml + "]\n");
    EXPECT_NE(message.find("more than 100000 values"), std::string::npos) << message.substr(0, 300);
    EXPECT_EQ(message.find("alias"), std::string::npos) << message.substr(0, 300);
}

TEST_F(CaseErrors, HonestAliasesAndAByteOrderMarkWork) {
    EXPECT_EQ(errors("\xEF\xBB\xBF"
                     "case: wing\nsurface: {file: wing.obj}\nregions:\n  a: {box: &b [[0, 0, 0], [1, 1, 1]]}\n"
                     "  b: {box: *b}\nfixed: [a, b]\n"),
              "");
}

/// As editors of Windows write them: a mark, lines that end in two characters; also files that a case names, in a
/// folder with a space.
TEST_F(CaseErrors, FilesOfWindowsSayTheSame) {
    const auto with_carriage_returns = [](const std::string& lines) {
        std::string out;
        for (const char c : lines) out += c == '\n' ? "\r\n" : std::string(1, c);
        return out;
    };
    const auto resolved = [&](const Case& read) { return resolved_case(read, folder.path()); };
    const std::string yaml = with("flap.txt", "\"of windows/flap.txt\"");
    folder.write("of windows/flap.txt", "0\n");
    const std::string here = resolved(load_case(file(yaml)));
    folder.write("of windows/flap.txt", with_carriage_returns("0\n"));
    EXPECT_EQ(resolved(load_case(file("\xEF\xBB\xBF" + with_carriage_returns(yaml)))), here);
    EXPECT_NE(resolved(load_case(file(with("volume: {min: 1.0", "volume: {min: 0.9")))), here);
}

TEST_F(CaseErrors, PathsOfWindowsAreExplained) {
    EXPECT_EQ(errors("case: wing\nsurface: {file: 'C:\\data\\wing.obj'}\n"),
              "case.yaml:2:17: surface.file = C:\\data\\wing.obj does not exist (C:\\data\\wing.obj); in WSL this path "
              "of Windows is "
              "/mnt/c/data/wing.obj");
    EXPECT_EQ(errors("case: wing\nsurface: {file: data\\wing.obj}\n"),
              "case.yaml:2:17: surface.file = data\\wing.obj does not exist (data\\wing.obj); in Linux folders are "
              "separated by '/': "
              "data/wing.obj");
}

TEST_F(CaseErrors, FilesThatAreNone) {
    EXPECT_THROW(load_case(folder.path() / "missing.yaml"), CaseError);
    EXPECT_THROW(load_case(folder.path()), CaseError);
    EXPECT_THROW(load_case("/dev/zero"), CaseError);
    EXPECT_EQ(errors("case: wing\nsurface: {file: .}\n"), "case.yaml:2:17: surface.file = . is not a regular file");
}

TEST_F(CaseErrors, PathsAreTakenAsTheyStandAndRelativeToTheCase) {
    for (const char* name : {"~/wing.obj", "${HOME}/wing.obj", "$PWD/wing.obj", "%HOME%/wing.obj"})
        EXPECT_EQ(errors(text("case: wing\nsurface: {file: '", name, "'}\n")),
                  text("case.yaml:2:17: surface.file = ", name, " does not exist (", name, ")"));
    const std::string path = file("case: wing\nsurface: {file: wing.obj}\n");
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path("/");
    const Case elsewhere = load_case(path);
    std::filesystem::current_path(before);
    EXPECT_EQ(elsewhere.surface, folder.path() / "wing.obj");
}

TEST_F(CaseErrors, MessagesAreSafeToPrint) {
    EXPECT_EQ(errors("case: \"a\\x1b[31m\\nb\"\nsurface: {file: wing.obj}\n"),
              "case.yaml:1:7: case = a\\x1B[31m\\x0Ab must be a name of letters, digits, '_' and '-'");
}

}  // namespace
}  // namespace strake
