#include "casefile/read/case_reader.hpp"
#include "optimize/nlp/program/methods.hpp"

namespace strake {

void CaseReader::read_optimize(const Value& map) {
    OptimizeOptions& o = case_.optimize;
    if (const Value* v = map.find("method")) {
        const MethodFacts* method = method_named(v->text);
        o.chooses_method = !method;  // auto
        if (method) o.method = method->method;
    }
    set(o.batch, map.find("batch"));
    set(o.finite_differences, map.find("finite_differences"));
    if (const Value* v = map.find("symmetry")) o.ignores_symmetry = v->number == 0;
    set(o.difference_step, map.find("difference_step"));
    if (const Value* v = map.find("starts"); v && v->text != "auto") {
        set(o.starts, v);
        o.ignores_waves = true;
    }
    if (const Value* v = map.find("seed")) o.seed = static_cast<unsigned>(v->number);
    if (const Value* v = map.find("start_from")) {
        case_.start_from = dir_ / v->text;
        case_.start_place = v->place;
    }
    read_fitting(map);
    read_stopping(map);
}

void CaseReader::read_sample(const Value& map) {
    const Value* method = map.find("method");
    const std::string word = method ? method->text : "";
    case_.sample = word == "lhs" ? Spread::lhs : word == "levels" ? Spread::levels : Spread::sobol;
    if (const Value* v = map.find("table")) {
        case_.sample_table = dir_ / v->text;
        case_.sample_place = v->place;
    }
}

void CaseReader::read_fitting(const Value& map) {
    if (const Value* v = map.find("loss"))
        case_.fitting.loss = v->text == "huber"     ? Loss::huber
                             : v->text == "cauchy"  ? Loss::cauchy
                             : v->text == "soft_l1" ? Loss::soft_l1
                                                    : Loss::none;
    if (const Value* v = map.find("loss_scale")) case_.loss_scale = length_of(*v);
    set(case_.fitting.icp_iterations, map.find("icp_iterations"));
}

/// When a level or the run ends.
void CaseReader::read_stopping(const Value& map) {
    OptimizeOptions& o = case_.optimize;
    if (const Value* budget = map.find("budget")) {
        set(o.max_evaluations, budget->find("evaluations"));
        set(o.max_seconds, budget->find("time"));
    }
    if (const Value* refine = map.find("refine_when")) {
        set(o.progress_below, refine->find("progress_below"));
        set(o.min_expected_gain, refine->find("min_expected_gain"));
    }
    if (const Value* tolerances = map.find("tolerances")) {
        set(o.objective_tolerance, tolerances->find("objective"));
        set(o.step_tolerance, tolerances->find("step"));
        set(o.constraint_tolerance, tolerances->find("constraint"));
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
    if (const Value* v = map.find("report")) {
        case_.output.report = v->text == "true";
        case_.output.report_is_stated = !v->from_default;
    }
}

}  // namespace strake
