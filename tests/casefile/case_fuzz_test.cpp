#include "casefile/build/build_problem.hpp"
#include "casefile/load_case.hpp"
#include "casefile/read/resolved_case.hpp"
#include "casefile/schema/schema.hpp"
#include "tests/casefile/folder.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <cstdint>
#include <cstdlib>

/// Mutants of a case: whatever happens to the text, the loader ends in a case or in a CaseError.
namespace strake {
namespace {

const char* optimization = R"(case: wing
surface: {file: wing.obj, units: mm}
repair: {joints: 2%, weld: 1e-6, duplicates: true, degenerate: true, cracks: 0.1mm, orient: true, split: true, holes: 5%,
         fill: smooth, components: {largest: 2, min_area: 1%, min_triangles: 4}, isolated: true}
regions:
  root: &r {box: [[-1, -1, -1], [1, 0.01, 1]]}
  tip:  {plane: {normal: [0, 1, 0], at: 0.5}, side: above}
  ball: {sphere: {center: [0, 0, 0], radius: 5%}}
  flap: {triangles: flap.txt}
  copy: *r
  both: tip + (copy - "ball") & all
  wide: {grow: {of: tip + ball, by: -2%}}
  face: {flood: {from: [0, 0, 0], angle: 20deg}}
  some: {flood: {from: 3}}
  next: {near: {of: tip, within: 3%}, touch: any}
  top:  {facing: -z, within: 60deg}
  side: {facing: [0, 1, 1]}
  spar: {of: left, chord: [15%, 65%], span: [0%, 95%], side: upper}
  nose: {of: left, edge: leading}
fixed: [root]
invariance: {extrude: y}
symmetry: {plane: y, at: 0, snap: 0.01%}
planform:
  left: {on: tip + ball, span: y, keep: none, stations: [0, 37%, 1], axis: 25% chord, values: [area, twist@0.5],
         grid: {span: [10%, 90%], chord: [15%, 65%]}, box: {chord: [20%, 60%], span: [0, 0.9]}}
  fin: {span: [0, 0, 1], behind: left, values: [gap@0.5]}
  hull: {on: all - tip, length: -x, stations: [0, 0.4, 1], values: [length, width@0.5]}
  pod: {length: [1, 0, 0]}
shell: {thickness: {default: 2%, root: 4%}, spring: 0, nonmanifold: couple, solver: multigrid}
loads:
  - {region: tip, traction: [0.0, 0.0, 0.001]}
  - {region: ball, displacement: 5%, direction: [0, 0, 1], spring: 2}
strains:
  - {region: flap, translate: [0, 0, 0.1], rotate: [0deg, 5deg, 0.1rad], about: [1mm, 0, 0]}
attach: [{part: nacelle, to: 0, how: follow}, {part: flap, to: nacelle, how: rigid}]
parameters: {levels: [20deg, 10deg], min_patch: 1%, variables: [load], variable_scale: 4%, max_displacement: {default: 3%, tip: {inward: 1%, outward: 0}, flap: 2%}, planform: {left.chord: {by: station, root: held, thickness: kept, range: [-4%, 4%]}, left.span: {range: [-5%, 5%]}, fin.aft: {range: [-2%, 1%]}, left.twist@0.37: {range: [-1deg, 1deg]}, hull.width: {by: station, range: [-3%, 3%]}}, fields: {number: 12, on: tip, axis: [0, 1, 0]}, keep: smooth_border, split: {containing: [1, {near: [0, 0, 0]}]}}
quantities:
  match: {type: target_shape, file: wing.obj, match: same}
  aero: {command: [sh, "-c", "true"], outputs: [drag, lift], timeout: 2h, format: stl, retries: 2, on_failure: shrink_step,
         gradient_command: [sh, "-c", "true"], gradient_timeout: 3h, gradient_points: wing.obj, support_radius: 50%, convergence: log/history.csv,
         parallel: 4, cache: answers, cache_files: [wing.obj]}
  lib: {plugin: {library: flap.txt, options: a b}, outputs: [x, y], on_failure: shrink_step}
objective: {minimize: aero.drag}
constraints:
  volume: {min: 1.0, relative: true}
  aero.lift: {equals: 0.3}
  left.twist@0.37: {min: -2deg}
  left.thickness_grid: {min: 1.0, relative: true}
  left.twist_step_grid: {max: 1deg}
optimize: {method: sqp, budget: {evaluations: 200, time: 1h}, refine_when: {progress_below: 1%, min_expected_gain: 0.2%}}
output: {dir: runs/wing, paraview: best, report: true}
)";

const char* ties_and_starts = R"(case: body
surface: {file: wing.obj, units: in}
repair: {joints: 2%, all: true, fill: planar}
remesh: {edge_length: 1%, angle: 20deg, iterations: 3, curvature: 0.1%, shortest_edge: 0.1 in, gradation: 0.5}
regions:
  nose: {component: 0}
  base: {patch: p1.2}
  wing: {solid: left wing}
  flap: {component: 1}
fixed: [nose]
shell: {thickness: 3%}
wrap: {alpha: 2%, offset: 1%, edge_length: 1%}
loads: [{region: base, force: [0, 0, 1]}]
parameters:
  levels: auto
  patches_per_level: [4, 16]
  sharp_angle: 35deg
  variables: [load, stiffness]
  directions: [[0, 0, 1], [1, 0, -1]]
  max_displacement: 2 mm
  split: sensitivity
  marking_fraction: 80%
  max_variable_ratio: 2.5
  variables_on: [base, wing]
  frozen: [nose]
  groups: [[p1.1, p1.2], [base, wing]]
  mirror: true
  given:
    - {name: lift, region: wing, load: normal, max_displacement: 3%}
    - {name: push, region: base, load: [0, 0, 1]}
    - {name: slide, region: flap, translate: [0, 1, 0]}
    - {name: hinge, region: p1.1, rotate: [0, 1, 0], about: [0, 0, 0], max_angle: 5deg}
    - {name: turn, twist: [0, 1, 0], about: [0, 0, 0], stations: [0, 1 in, 2 in]}
quantities:
  thin: {type: thickness, at: lines.csv, values: smallest}
  cfd: {command: [sh, run.sh, "{surface}"], gradients: false, on_failure: {value: 1e3}, depends_on: [alpha],
    scheduler: {slurm: [--partition=short, --ntasks=8], wait: 2h, poll: 30s}}
variables: {alpha: {start: 3deg, min: 0, max: 6deg}}
objective: {maximize: volume}
constraints:
  area: {max: 1.01, relative: true}
  thin: {min: 0.1}
optimize:
  method: NLOPT_LD_MMA
  finite_differences: true
  difference_step: 0.05
  starts: 3
  seed: 7
  batch: 4
  start_from: runs/before
  budget: {evaluations: 40}
  tolerances: {objective: 1e-5, step: 1e-4, constraint: 1e-7}
sample: {method: lhs, table: lines.csv}
)";

const char* robust_fit = R"(surface: {file: wing.obj}
hold: {point: [0, 0, 0]}
invariance: {cyclic: 6, about: [1, 0, 0], through: [0, 0, 1]}
symmetry: {plane: {normal: [0, 1, 0]}, at: 0.5, coefficients: whole}
parameters: {variables: [strain_translation, normal], free_border: 30%, split: {largest: 2}}
quantities:
  scan: {type: measured_points, file: points.csv}
  spars: {type: thickness, at: lines.csv, values: each}
  rib: {type: section_area, plane: {normal: [0, 0, 2], at: 0.5}, target: 0.1}
  match: {type: target_shape, file: wing.obj, match: closest}
fit: [scan, spars, rib, match]
optimize: {loss: cauchy, loss_scale: 0.2%, icp_iterations: 2}
output: {paraview: none, keep: best}
)";

const char* goals = R"(surface: {file: wing.obj}
hold: point
invariance: {revolve: x}
regions: {nose: {box: [[0, 0, 0], [1, 1, 1]]}}
variables: {alpha: {start: 3deg, min: 0, max: 6deg}}
axes: {downstream: +x, up: [0, 0, 1]}
quantities:
  aero: {type: newtonian, mach: 6, alpha: {variable: alpha}, beta: 2deg, leeward: prandtl_meyer, moment_center: [0, 0, 1],
         gamma: 1.3, shadows: false, up: [0, 0, 1], reference_area: 2, reference_length: 3}
  blunt: {type: newtonian, cp_max: 2}
  wave: {type: wave_drag, mach: 1.4, stations: 12, angles: 3, base: nose, beside: wing.obj, forward: [1, 0, 0]}
  skin: {type: friction, reynolds: 1e6, boundary_layer: laminar, wall_temperature: 2, temperature: 220}
  span: {type: extent, direction: [0, 1, 0], smoothing: 1%}
  wall: {type: wall_thickness, region: nose, sharpness: 20}
  sharp: {type: creases, angle: 20deg}
  keep: {type: clearance, file: wing.obj, side: keep_in, smoothing: 0.1%}
  edge: {type: edge_radius, region: nose, plane: {normal: [0, 0, 1], at: 0.1}}
  cfd: {command: [sh, run.sh], outputs: [drag, lift], gradients: false, low_fidelity: aero}
  heat: {command: [sh, run.sh], outputs: [peak, mean], low_fidelity: {peak: blunt.drag, mean: ld}}
  ld: {expression: 'aero.lift / (aero.drag + skin) ^ 2 - softmin(0.1, wave, alpha)'}
objective: {maximize: 'ld - 2 * min(wave, keep) - cfd.drag - heat.peak - heat.mean'}
constraints:
  ld: {min: 1}
  span.length: {equals: 1, relative: true}
)";

const char* without_shell = R"(surface: {file: wing.obj}
regions:
  tip: {box: [[0.4, -1, -1], [3, 1, 1]]}
fixed: [tip]
shell: none
parameters: {fields: {number: auto, axis: x, motions: [scale, move], along: splines, kind: sections}, variables: []}
objective: {minimize: area}
)";

const char* seeds[] = {optimization, ties_and_starts, robust_fit, goals, without_shell};

const char* pieces[] = {"{",    "}",   "[",    "]",    ":",   ": ",    "- ",  "&a ", "*a ",  "<<: ", "!x ",   "'",
                        "\"",   "\t",  "\n",   "# ",   "|\n", ">\n",   "? ",  "%",   "deg",  "mm",   "1e999", "-",
                        ".nan", "0x1", "\xFF", "null", "~",   "---\n", "010", "1_0", "root", "all",  "\\x",   ","};

class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ull + 1) {}
    std::size_t below(std::size_t n) {
        state_ ^= state_ << 13;
        state_ ^= state_ >> 7;
        state_ ^= state_ << 17;
        return static_cast<std::size_t>(state_ % n);
    }

private:
    std::uint64_t state_;
};

std::string mutated(std::string yaml, Random& random) {
    for (std::size_t k = 1 + random.below(2) * random.below(4); k > 0 && !yaml.empty(); --k) {
        const std::size_t at = random.below(yaml.size()), length = 1 + random.below(12);
        switch (random.below(6)) {
            case 0:
                yaml.erase(at, length);
                break;
            case 1:
                yaml.insert(at, pieces[random.below(std::size(pieces))]);
                break;
            case 2:
                yaml.insert(random.below(yaml.size()), yaml.substr(at, length * 4));
                break;
            case 3:
                yaml[at] = static_cast<char>(random.below(256));
                break;
            case 4:  // another digit
                if (const std::size_t digit = yaml.find_first_of("0123456789", at); digit != std::string::npos)
                    yaml[digit] = static_cast<char>('0' + random.below(10));
                break;
            default:
                yaml.replace(at, length, pieces[random.below(std::size(pieces))]);
                break;
        }
    }
    return yaml;
}

/// Names of the last keys of the path that an author writes: not `*` and `[]`.
std::string written_key(const std::string& path) {
    std::string key = path.substr(path.rfind('.') + 1);
    while (key.ends_with("[]")) key.resize(key.size() - 2);
    return key;
}

TEST(CaseFuzz, SeedsHoldEveryKeyOfTheSchema) {
    std::string all;
    for (const char* seed : seeds) all += seed;
    for (const Key& key : schema()) {
        const std::string name = written_key(key.path);
        if (name == "*") continue;
        EXPECT_TRUE(all.find("\n" + name + ":") != std::string::npos ||
                    all.find(" " + name + ":") != std::string::npos || all.find("{" + name + ":") != std::string::npos)
            << key.path;
    }
}

TEST(CaseFuzz, MutantsEndInACaseOrInAnError) {
    const Folder folder;
    folder.write("wing.obj", tetrahedron_obj);
    folder.write("flap.txt", "0\n");
    folder.write("lines.csv", "0.2,0.2,0.1,0,0,1,0.5\n");
    folder.write("points.csv", "0.2,0.2,0.1\n0.3,0.1,0,2\n");
    for (const char* of_slurm :
         {"sbatch", "squeue", "sacct", "scancel"})  // cases name them; machines need not have them
        std::filesystem::permissions(folder.write(of_slurm, "#!/bin/sh\n"), std::filesystem::perms::owner_all);
    const char* path = std::getenv("PATH");
    setenv("PATH", (folder.path().string() + ":" + (path ? path : "/usr/bin:/bin")).c_str(), 1);
    // More of them by hand: STRAKE_MUTANTS=100000.
    const char* wanted = std::getenv("STRAKE_MUTANTS");
    const int count = wanted ? std::max(1000, std::atoi(wanted)) : 2000;
    int legal = 0, refused = 0;
    for (int k = 0; k < count; ++k) {
        Random random(static_cast<std::uint64_t>(k) + 1);
        const bool is_seed = k < static_cast<int>(std::size(seeds));
        const char* seed = seeds[static_cast<std::size_t>(k) % std::size(seeds)];
        const std::string yaml = is_seed ? seed : mutated(seed, random);
        const auto file = folder.write("case.yaml", yaml);
        try {
            const Case c = load_case(file);
            ++legal;
            const auto again = load_case(folder.write("again.yaml", resolved_case(c, folder.path())));
            EXPECT_EQ(resolved_case(again, folder.path()), resolved_case(c, folder.path())) << yaml;
        } catch (const CaseError& e) {
            ++refused;
            EXPECT_FALSE(e.diagnostics.empty());
            EXPECT_FALSE(is_seed) << e.what();
        }
    }
    EXPECT_GT(legal, 20);
    EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace strake
