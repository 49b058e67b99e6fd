#include "core/error.hpp"
#include "python/bindings.hpp"

#include <limits>
#include <set>

/// Triangles, patches per level, corners: whole numbers that numpy would silently round or wrap.
namespace strake::python {
namespace {

using WideInts = py::array_t<long long, py::array::c_style | py::array::forcecast>;

/// As a numpy array. @throws InvalidInput if numpy only makes an array of objects.
py::array as_array(const py::object& given, const std::string& what, const char* wanted) {
    py::array array = py::array::ensure(given);
    if (!array || array.dtype().kind() == 'O' || array.dtype().kind() == 'U' || array.dtype().kind() == 'S')
        throw InvalidInput(text(what, " = ", shown(given), " must be ", wanted));
    return array;
}

std::string shape_of(const py::array& array) { return py::str(array.attr("shape")).cast<std::string>(); }

/// @throws InvalidInput for numbers that are not whole, which numpy would truncate.
WideInts whole(const py::array& array, const std::string& what, const char* wanted) {
    if (array.size() > 0 && array.dtype().kind() != 'i' && array.dtype().kind() != 'u') {
        const py::object first = array.attr("flat")[py::int_(0)];
        throw InvalidInput(text(what, ": ", shown(first), " (", py::str(array.dtype()).cast<std::string>(),
                                ") is not a whole number; give ", wanted));
    }
    if (array.dtype().kind() == 'u' && array.itemsize() == 8 && array.size() > 0) {  // the upper half would wrap
        const py::object most = array.attr("max")();
        if (most.cast<unsigned long long>() > std::numeric_limits<int>::max())
            throw InvalidInput(text(what, ": ", shown(most), ", limit ", std::numeric_limits<int>::max()));
    }
    return WideInts(array);
}

std::vector<int> marked(const py::array& mask, const TriMesh& surface, const std::string& what) {
    if (mask.size() != surface.num_triangles())
        throw InvalidInput(text(what, ": a mask of ", mask.size(), " booleans, must be ", surface.num_triangles(),
                                ", one for each triangle"));
    const py::array_t<bool, py::array::c_style | py::array::forcecast> flags(mask);
    std::vector<int> chosen;
    for (py::ssize_t t = 0; t < flags.size(); ++t)
        if (flags.data()[t]) chosen.push_back(static_cast<int>(t));
    return chosen;
}

/// NumPy 2 calls a number np.float64(0.5), which NumPy 1 and messages call 0.5.
bool is_number_of_numpy(const py::handle& thing) {
    const py::object dimensions = py::getattr(thing, "ndim", py::none());
    return py::hasattr(thing, "dtype") && py::isinstance<py::int_>(dimensions) && PyLong_AsLong(dimensions.ptr()) == 0;
}

}  // namespace

std::string shown(const py::handle& thing) {
    constexpr std::size_t enough = 60;
    PyObject* words = is_number_of_numpy(thing) ? PyObject_Str(thing.ptr()) : PyObject_Repr(thing.ptr());
    if (!words) {  // an int of more than 4300 digits has none
        PyErr_Clear();
        return "an unprintable value";
    }
    std::string all;  // on one line: arrays have several
    for (const char c : py::reinterpret_steal<py::str>(words).cast<std::string>()) {
        const bool is_blank = c == ' ' || c == '\n' || c == '\t' || c == '\r';
        if (!is_blank || all.empty() || all.back() != ' ') all += is_blank ? ' ' : c;
    }
    return all.size() <= enough ? all : all.substr(0, enough) + "...";
}

std::string current_name(const std::string& given, const char* before, const char* now, const char* what) {
    if (given != before) return given;
    const std::string words = text(what, ": '", before, "' is now '", now, "'; the old name goes at 1.0");
    if (PyErr_WarnEx(PyExc_DeprecationWarning, words.c_str(), 1) != 0) throw py::error_already_set();
    return now;
}

std::vector<int> triangles_of(const py::object& chosen, const TriMesh& surface, const std::string& what) {
    constexpr const char* wanted = "triangle numbers from 0, or a mask of booleans, one for each triangle";
    const py::array array = as_array(chosen, what, wanted);
    if (array.ndim() != 1)
        throw InvalidInput(text(what, ": an array of shape ", shape_of(array), ", must be a list of ", wanted));
    if (array.dtype().kind() == 'b') return marked(array, surface, what);
    const WideInts numbers = whole(array, what, wanted);
    std::set<int> sorted;
    for (py::ssize_t k = 0; k < numbers.size(); ++k) {
        const long long t = numbers.data()[k];
        if (t < 0 || t >= surface.num_triangles())
            throw InvalidInput(text(what, ": triangle ", t, ", limits 0 and ", surface.num_triangles() - 1));
        sorted.insert(static_cast<int>(t));
    }
    return {sorted.begin(), sorted.end()};
}

std::vector<int> counts_of(const py::object& given, const std::string& what) {
    constexpr const char* wanted = "a list of whole numbers";
    const py::array array = as_array(given, what, wanted);
    if (array.ndim() != 1 || array.dtype().kind() == 'b')
        throw InvalidInput(text(what, " = ", shown(given), " must be ", wanted));
    const WideInts numbers = whole(array, what, wanted);
    std::vector<int> counts;
    for (py::ssize_t k = 0; k < numbers.size(); ++k) {
        const long long n = numbers.data()[k];
        if (n < 1 || n > std::numeric_limits<int>::max())
            throw InvalidInput(text(what, ": ", n, ", limits 1 and ", std::numeric_limits<int>::max()));
        counts.push_back(static_cast<int>(n));
    }
    return counts;
}

Triangles corners_of(const py::object& given, Eigen::Index num_vertices, const std::string& what) {
    constexpr const char* wanted = "an m x 3 array of vertex numbers from 0";
    const py::array array = as_array(given, what, wanted);
    if (array.ndim() != 2 || array.shape(1) != 3)
        throw InvalidInput(text(what, ": an array of shape ", shape_of(array), ", must be ", wanted));
    const WideInts numbers = whole(array, what, wanted);
    Triangles corners(array.shape(0), 3);
    for (Eigen::Index t = 0; t < corners.rows(); ++t)
        for (int k = 0; k < 3; ++k) {
            const long long v = numbers.data()[3 * t + k];
            if (v < 0 || v >= num_vertices)
                throw InvalidInput(
                    text(what, ": triangle ", t, " has vertex ", v, ", limits 0 and ", num_vertices - 1));
            corners(t, k) = static_cast<int>(v);
        }
    return corners;
}

}  // namespace strake::python
