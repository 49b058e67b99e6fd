#include "casefile/yaml/diagnostics.hpp"
#include "core/error.hpp"
#include "core/primo/shell.hpp"
#include "core/version.hpp"
#include "python/bindings.hpp"
#include "python/evaluation_failed.hpp"

#include <cmath>

namespace strake::python {
namespace {

/// An exception class with these bases, which lives as long as the interpreter.
PyObject* add_error(py::module_& m, const char* name, const char* doc, const py::tuple& bases) {
    const std::string full = std::string("strake.") + name;
    PyObject* made = PyErr_NewExceptionWithDoc(full.c_str(), doc, bases.ptr(), nullptr);
    if (!made) throw py::error_already_set();
    m.attr(name) = py::reinterpret_borrow<py::object>(made);
    return made;
}

struct Errors {
    PyObject *base, *input, *file, *output, *solver, *unheld, *failed, *wrong_case;
};
Errors errors{};

void translate(std::exception_ptr thrown) {
    try {
        if (thrown) std::rethrow_exception(thrown);
    } catch (const UnheldPart& e) {
        PyErr_SetString(errors.unheld, e.what());
    } catch (const CaseError& e) {
        PyErr_SetString(errors.wrong_case, e.what());
    } catch (const InvalidInput& e) {
        PyErr_SetString(errors.input, e.what());
    } catch (const InputError& e) {
        PyErr_SetString(errors.file, e.what());
    } catch (const OutputError& e) {
        PyErr_SetString(errors.output, e.what());
    } catch (const SolverError& e) {
        PyErr_SetString(errors.solver, e.what());
    } catch (const EvaluationFailed& e) {
        PyErr_SetString(errors.failed, e.what());
    }
}

}  // namespace

bool is_evaluation_failed(const py::error_already_set& error) { return error.matches(errors.failed); }

void bind_errors(py::module_& m) {
    const auto borrowed = [](PyObject* o) { return py::reinterpret_borrow<py::object>(o); };
    const auto bases = [&](PyObject* builtin) { return py::make_tuple(borrowed(errors.base), borrowed(builtin)); };
    errors.base =
        add_error(m, "Error", "Base class of all errors of Strake.", py::make_tuple(borrowed(PyExc_Exception)));
    errors.input = add_error(m, "InvalidInput", "An argument is wrong; the message gives value and limit.",
                             bases(PyExc_ValueError));
    errors.wrong_case =
        add_error(m, "CaseError", "A case file is wrong; one line for each error, with file:line:column.",
                  py::make_tuple(borrowed(errors.input)));
    errors.file = add_error(m, "InputError", "A file is missing, unreadable or wrong; the message names the place.",
                            bases(PyExc_OSError));
    errors.output = add_error(m, "OutputError", "A file cannot be written.", bases(PyExc_OSError));
    errors.solver = add_error(m, "SolverError", "A linear system could not be solved.", bases(PyExc_RuntimeError));
    errors.unheld = add_error(m, "UnheldPart", "Nothing holds a part of the surface; the message names it.",
                              bases(PyExc_RuntimeError));
    errors.failed =
        add_error(m, "EvaluationFailed",
                  "There is no value or no valid shape here. If a quantity raises it, the run tries a shorter "
                  "step.",
                  bases(PyExc_RuntimeError));
    py::register_exception_translator(translate);
}

void check_rows(const Rows& rows, Eigen::Index expected, const char* what) {
    if (expected >= 0 && rows.rows() != expected)
        throw InvalidInput(text(what, ": ", rows.rows(), " rows, must be ", expected));
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
        if (!rows.row(i).allFinite()) throw InvalidInput(text(what, ": row ", i, " = ", rows.row(i), " is not finite"));
}

std::optional<SymmetryPlane> plane_of(const std::optional<PlaneTuple>& plane) {
    if (!plane) return {};
    const double size = plane->first.norm();
    if (!(size > 0) || !std::isfinite(size) || !std::isfinite(plane->second))
        throw InvalidInput(text("symmetry: the normal (", plane->first.transpose(), ") must be finite, not zero"));
    return SymmetryPlane{plane->first / size, plane->second / size};
}

PYBIND11_MODULE(_core, m) {
    py::options options;
    options.disable_function_signatures();
    m.doc() = "The compiled part of `strake`.";
    m.attr("__module__") = "strake";  // where users find what is in it
    m.attr("version") = version();
    m.attr("numpy_2") = PYBIND11_VERSION_HEX >= 0x020C0000;  // before 2.12 pybind11 knows NumPy 1 alone
    bind_errors(m);
    bind_surface(m);
    bind_patches(m);
    bind_shell(m);
    bind_problem(m);
    bind_run(m);
}

}  // namespace strake::python
