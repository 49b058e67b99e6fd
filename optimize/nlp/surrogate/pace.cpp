#include "optimize/nlp/surrogate/pace.hpp"

#include <algorithm>

namespace strake {
namespace {

using Eigen::VectorXd;

constexpr int parts = 4;  ///< of a search: the last one is compared with all

}  // namespace

void Pace::note(int evaluations, const VectorXd& best) { notes_.push_back({evaluations, best}); }

int Pace::part() const { return notes_.empty() ? 0 : (notes_.back().evaluations - notes_.front().evaluations) / parts; }

bool Pace::holds(double share, const std::function<double(const VectorXd&)>& merit, double more_than) const {
    if (notes_.empty()) return false;
    const int begin = notes_.front().evaluations, spent = notes_.back().evaluations - begin;
    const double start = merit(notes_.front().best), now = merit(notes_.back().best);
    double before_last = start;
    for (const Note& note : notes_)
        if (parts * (note.evaluations - begin) <= (parts - 1) * spent)
            before_last = std::min(before_last, merit(note.best));
    return before_last - now > more_than && before_last - now >= share * (start - now);
}

}  // namespace strake
