#pragma once
#include <Eigen/Core>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace strake {

/// The responses at rest that a run has computed, by the names of the variables. Forgotten when the pins change.
class ResponseCache {
public:
    struct Column {
        double largest;
        Eigen::VectorXd samples;     ///< displacements: `Responses::samples`
        Eigen::VectorXd laplacians;  ///< of these along the surface, likewise
        Eigen::VectorXd work_integrals;
    };
    /// Drops everything unless `pin` is that of the last call.
    void use(const std::vector<int>& pin);
    const Column* find(const std::string& key) const;
    void add(const std::string& key, Column column) { columns_[key] = std::move(column); }

    /// Asked while responses are computed; true: `Interrupted` is thrown. May be empty.
    std::function<bool()> stop_wanted;
    bool goes_on() const { return !(stop_wanted && stop_wanted()); }

private:
    std::vector<int> pin_;
    std::map<std::string, Column> columns_;
};

}  // namespace strake
