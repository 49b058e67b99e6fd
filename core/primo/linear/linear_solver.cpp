#include "core/primo/linear/linear_solver.hpp"

namespace strake {

std::string to_string(LinearSolver solver) {
    switch (solver) {
        case LinearSolver::automatic:
            return "auto";
        case LinearSolver::direct:
            return "direct";
        case LinearSolver::multigrid:
            return "multigrid";
    }
    return "unknown";
}

}  // namespace strake
