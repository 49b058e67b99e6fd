#include "casefile/schema/schema_parts.hpp"

namespace strake {
namespace {

std::vector<Key> command_keys() {
    return {
        {.path = "quantities.*.command",
         .type = Type::list,
         .doc = "Argument list, run without a shell; {surface} {request} {result} {folder} {case_dir} are replaced. A "
                "program path that contains '/' is relative to the case file.",
         .element = Type::text},
        {.path = "quantities.*.outputs",
         .type = Type::list,
         .doc = "Names of the values, referred to as quantity.value. Default: one value, named like the quantity.",
         .element = Type::name,
         .when = "command|plugin"},
        {.path = "quantities.*.timeout",
         .type = Type::duration,
         .doc = "Time limit of one evaluation; after it the whole process group is killed.",
         .fallback = "1h",
         .limits = positive,
         .when = "command"},
        {.path = "quantities.*.format",
         .type = Type::word,
         .doc = "Format of the surface handed to the program. Default: the format of the surface file.",
         .words = {"stl", "stl-ascii", "obj", "ply", "ply-ascii", "off", "tri", "vtk", "vtp", "su2", "su2-positions",
                   "msh", "nastran"},
         .when = "command"},
        {.path = "quantities.*.convergence",
         .type = Type::text,
         .doc = "A file that the program writes into its folder while it iterates: a table (SU2's history.csv, "
                "OpenFOAM's solverInfo.dat) or OpenFOAM's log. The studio draws it.",
         .when = "command"},
        {.path = "quantities.*.gradient_command",
         .type = Type::list,
         .doc = "Run after `command`, in the same folder, when gradients are requested; {request} and {result} are "
                "then gradient_request.json and gradient.json. Default: `command` returns both.",
         .element = Type::text,
         .when = "command"},
        {.path = "quantities.*.gradient_timeout",
         .type = Type::duration,
         .doc = "Time limit of one gradient_command. Default: `timeout`.",
         .limits = positive,
         .when = "gradient_command"},
        {.path = "quantities.*.gradient_points",
         .type = Type::file,
         .doc = "Points of the program's own mesh on or near the start surface (.csv with x,y,z and optionally "
                "PointID, .npy, or a surface). The program receives their displaced positions, and its gradients "
                "refer to them.",
         .when = "command"},
        {.path = "quantities.*.support_radius",
         .type = Type::length,
         .doc = "Distance from the surface beyond which these points do not move.",
         .fallback = "100%",
         .limits = positive,
         .when = "gradient_points"},
        {.path = "quantities.*.plugin",
         .doc = "A shared library in place of a command, loaded into Strake (include/strake/plugin.h)."},
        {.path = "quantities.*.plugin.library", .type = Type::file, .doc = "The library.", .required = true},
        {.path = "quantities.*.plugin.options", .type = Type::text, .doc = "Passed to the library unchanged."},
        {.path = "quantities.*.gradients",
         .type = Type::flag,
         .doc = "Whether the program returns gradients (per vertex, and with respect to `variables`). If false, "
                "optimize needs a derivative-free method, or finite_differences.",
         .fallback = "true",
         .when = "command|plugin"},
        {.path = "quantities.*.low_fidelity",
         .type = Type::text,
         .doc = "A cheap model of the program: a quantity with values of the same names, or one value for one. The "
                "search looks for the optimum of the cheap model and corrects it by what the program says.",
         .when = "command|plugin"},
        {.path = "quantities.*.low_fidelity",
         .doc = "The same by value: names of outputs, each with the value that stands for it.",
         .when = "command|plugin"},
        {.path = "quantities.*.low_fidelity.*", .type = Type::text, .doc = "The cheap value of this output."},
        {.path = "quantities.*.depends_on",
         .type = Type::list,
         .doc = "Those of `variables` that its values depend on; may be empty. Derivatives with respect to the others "
                "are zero and not requested. Default: all.",
         .element = Type::name,
         .when = "command|plugin",
         .may_be_empty = true},
    };
}

std::vector<Key> failure_keys() {
    return {
        {.path = "quantities.*.retries",
         .type = Type::integer,
         .doc = "Number of further attempts after a failure, with increasing pauses; none if the program cannot be "
                "started. Retries do not count as evaluations.",
         .fallback = "0",
         .limits = not_negative,
         .when = "command"},
        {.path = "quantities.*.on_failure",
         .type = Type::word,
         .doc = "After the last attempt: abort ends the run, which can be resumed; shrink_step rejects the design and "
                "continues with shorter steps.",
         .fallback = "abort",
         .words = {"abort", "shrink_step"},
         .when = "command|plugin"},
        {.path = "quantities.*.on_failure",
         .doc = "A substitute value for failed evaluations; only with `gradients: false`.",
         .when = "command|plugin"},
        {.path = "quantities.*.on_failure.value",
         .type = Type::number,
         .doc = "The substitute for each of its values.",
         .required = true},
    };
}

std::vector<Key> scheduling_keys() {
    return {
        {.path = "quantities.*.parallel",
         .type = Type::integer,
         .doc = "Maximum number of concurrent evaluations; results do not depend on it. If any quantity states it, the "
                "programs of one evaluation also run concurrently.",
         .fallback = "1",
         .limits = {1, 1024, false, false},
         .when = "command"},
        {.path = "quantities.*.scheduler", .doc = "Submit each evaluation as a batch job.", .when = "command"},
        {.path = "quantities.*.scheduler.slurm",
         .type = Type::list,
         .doc = "Options of sbatch, for example [--partition=short, --ntasks=8].",
         .required = true,
         .element = Type::text,
         .may_be_empty = true},
        {.path = "quantities.*.scheduler.wait",
         .type = Type::duration,
         .doc = "Maximum time a job may be pending; `timeout` starts when the job does.",
         .fallback = "168h",
         .limits = positive},
        {.path = "quantities.*.scheduler.poll",
         .type = Type::duration,
         .doc = "Minimum time between two queries of the queue.",
         .fallback = "2s",
         .limits = positive},
        {.path = "quantities.*.cache",
         .type = Type::path,
         .doc = "Folder with results shared between runs: a program is not run again for the same surface, variables, "
                "command and files.",
         .when = "command"},
        {.path = "quantities.*.cache_files",
         .type = Type::list,
         .doc = "Files that the results depend on, besides the program itself (settings, meshes).",
         .element = Type::file,
         .when = "cache"},
    };
}

}  // namespace

std::vector<Key> program_keys() { return in_order({command_keys(), failure_keys(), scheduling_keys()}); }

}  // namespace strake
