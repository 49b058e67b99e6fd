#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

/// How fast a search has gained, from what it has noted on its way. Internal.
namespace strake {

class Pace {
public:
    /// @param best values of the best point after so many evaluations, which do not decrease from one call to the next
    void note(int evaluations, const Eigen::VectorXd& best);
    /// The last quarter of the evaluations has gained at least this share of all that the search has.
    /// @param merit of values: what is smaller is better @param more_than this: less may be noise
    bool holds(double share, const std::function<double(const Eigen::VectorXd&)>& merit, double more_than = 0) const;
    /// Evaluations of a quarter.
    int part() const;

private:
    struct Note {
        int evaluations = 0;
        Eigen::VectorXd best;
    };
    std::vector<Note> notes_;
};

}  // namespace strake
