#include "casefile/read/case_reader.hpp"
#include "optimize/nlp/program/methods.hpp"

namespace strake {

void CaseReader::read_optimize(const Value& map) {
    OptimizeOptions& o = case_.optimize;
    if (const Value* v = map.find("method"))
        if (const MethodFacts* method = method_named(v->text)) o.method = method->method;
    if (const Value* v = map.find("finite_differences")) o.finite_differences = v->number != 0;
    if (const Value* v = map.find("difference_step")) o.difference_step = v->number;
    if (const Value* v = map.find("starts")) o.starts = static_cast<int>(v->number);
    if (const Value* v = map.find("seed")) o.seed = static_cast<unsigned>(v->number);
    if (const Value* v = map.find("start_from")) {
        case_.start_from = dir_ / v->text;
        case_.start_place = v->place;
    }
    if (const Value* v = map.find("loss"))
        case_.fitting.loss = v->text == "huber"     ? Loss::huber
                             : v->text == "cauchy"  ? Loss::cauchy
                             : v->text == "soft_l1" ? Loss::soft_l1
                                                    : Loss::none;
    if (const Value* v = map.find("loss_scale")) case_.loss_scale = length_of(*v);
    if (const Value* v = map.find("icp_iterations")) case_.fitting.icp_iterations = static_cast<int>(v->number);
    if (const Value* budget = map.find("budget")) {
        if (const Value* v = budget->find("evaluations")) o.max_evaluations = static_cast<int>(v->number);
        if (const Value* v = budget->find("time")) o.max_seconds = v->number;
    }
    if (const Value* refine = map.find("refine_when")) {
        if (const Value* v = refine->find("progress_below")) o.progress_below = v->number;
        if (const Value* v = refine->find("min_expected_gain")) o.min_expected_gain = v->number;
    }
    if (const Value* tolerances = map.find("tolerances")) {
        if (const Value* v = tolerances->find("objective")) o.objective_tolerance = v->number;
        if (const Value* v = tolerances->find("step")) o.step_tolerance = v->number;
        if (const Value* v = tolerances->find("constraint")) o.constraint_tolerance = v->number;
    }
}

void CaseReader::read_output(const Value& map) {
    if (const Value* v = map.find("dir")) case_.output.dir = dir_ / (v->from_default ? "runs/" + case_.name : v->text);
    if (const Value* v = map.find("paraview"))
        case_.output.paraview = v->text == "best"   ? ParaView::best
                                : v->text == "none" ? ParaView::none
                                                    : ParaView::every_accepted;
    if (const Value* v = map.find("keep"))
        case_.output.keep = v->text == "failed" ? Keep::failed
                            : v->text == "best" ? Keep::best
                            : v->text == "none" ? Keep::none
                                                : Keep::all;
    if (const Value* v = map.find("report")) case_.output.report = v->text == "true";
}

}  // namespace strake
