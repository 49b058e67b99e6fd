#include "core/planform/varying.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace strake {

Varying scaled(double f, double a, const Varying& da) {
    Varying result(f, da.slope);
    for (auto& [coordinate, derivative] : result.slope) derivative *= a;
    return result;
}

Varying combined(double f, double a, const Varying& da, double b, const Varying& db) {
    if (db.slope.empty()) return scaled(f, a, da);
    if (da.slope.empty()) return scaled(f, b, db);
    Varying result(f);
    result.slope.reserve(da.slope.size() + db.slope.size());
    auto i = da.slope.begin(), j = db.slope.begin();
    while (i != da.slope.end() || j != db.slope.end()) {
        const bool first = j == db.slope.end() || (i != da.slope.end() && i->first <= j->first);
        const bool both = first && j != db.slope.end() && i->first == j->first;
        result.slope.emplace_back(first ? i->first : j->first,
                                  (first ? a * i->second : 0) + (!first || both ? b * j->second : 0));
        if (first) ++i;
        if (!first || both) ++j;
    }
    return result;
}

Varying sqrt(const Varying& a) {
    const double root = std::sqrt(a.value);
    return scaled(root, root > 0 ? 0.5 / root : 0, a);
}

Varying atan2(const Varying& y, const Varying& x) {
    const double square = y.value * y.value + x.value * x.value;
    return combined(std::atan2(y.value, x.value), x.value / square, y, -y.value / square, x);
}

Varying sum(const std::vector<Varying>& terms) {
    Varying total;
    std::map<int, double> slope;
    for (const Varying& term : terms) {
        total.value += term.value;
        for (const auto& [coordinate, derivative] : term.slope) slope[coordinate] += derivative;
    }
    total.slope.assign(slope.begin(), slope.end());
    return total;
}

}  // namespace strake
