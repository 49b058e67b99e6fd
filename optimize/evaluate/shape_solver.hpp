#pragma once
#include "optimize/evaluate/shape_evaluation.hpp"
#include "optimize/evaluate/validity.hpp"
#include "optimize/space/design_space.hpp"
#include "optimize/space/motion_limit.hpp"

#include <functional>

/// From a design to its surface: x -> loads -> equilibrium -> a valid surface. Internal to the evaluator.
namespace strake {

/// The guard of a problem's shapes: of the surface, and of the wrap that carries it.
struct ShapeGuard {
    ValidityGuard surface;
    std::optional<ValidityGuard> wrap = {};
};
ShapeGuard guard_of(const Problem& problem, const std::shared_ptr<const RestFacts>& rest);

/// What the guard says of a surface in the equilibrium of `demand`. A surface in a wrap is moved by a map of space, as
/// one without a shell is, and the wrap must be sound as well. @param shell in that equilibrium; null: there is none.
std::string defect_of(const ShapeGuard& guard, const RestFacts& rest, const ShellDemand& demand, const Points& vertices,
                      const PrimoShell* shell);

/// Keeps the shell, its factor and the poses of the last shapes between designs. Not thread-safe.
class ShapeSolver {
public:
    ShapeSolver(const Problem& problem, std::shared_ptr<const RestFacts> rest);

    /// Solves in this space from now on; the accepted poses are kept.
    void enter(const DesignSpace& space);
    void set_ranges(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper);
    const DesignSpace& space() const { return space_; }
    /// Asked after every iteration; true: `Interrupted` is thrown. May be empty.
    void set_stop(std::function<bool()> stop_wanted) { stop_wanted_ = std::move(stop_wanted); }
    /// Shapes beyond it are refused from now on. @param poses of its datum; equilibria are sought from there first.
    void set_limit(MotionLimit limit, std::optional<Poses> poses);
    const MotionLimit& limit() const { return limit_; }
    /// Edges that designs keep from folding, under a motion limit: of a shell's surface, and of a border of what is
    /// held that is kept smooth.
    const EdgeFolds& edge_folds() const;
    /// Designs do not follow each other: from now on every equilibrium is sought from the datum (without a limit: from
    /// rest), by any way that the shell knows. What a design gives depends on it alone.
    void solve_each_from_datum() { is_each_from_datum_ = true; }
    /// There is no datum: every shape is refused with this reason.
    void refuse_all(std::string reason) { no_datum_ = std::move(reason); }

    /// Fills vertices and max_displacement, or status and reason: false. @throws Interrupted, UnheldPart, InvalidInput.
    bool deform(const Eigen::VectorXd& x, ShapeEvaluation& result);
    /// `deform` would succeed now. The last design stays what it is. @throws as `deform`.
    bool has_shape(const Eigen::VectorXd& x);
    /// Why `deform` would refuse the surface of the equilibrium; empty: it would not, or there is none. The same.
    std::string refusal(const Eigen::VectorXd& x);
    /// The equilibrium only, valid or not: vertices, or status and reason. Nothing is done for the x of the last call.
    bool settle(const Eigen::VectorXd& x, ShapeEvaluation& result);
    /// The same as `deform` after setting the accepted poses, but that the motion limit is not asked; where it
    /// succeeds, its equilibrium is accepted.
    bool begin_from(const Poses& poses, const Eigen::VectorXd& x, ShapeEvaluation& result);

    /// The design that was evaluated last: what `accept` accepts. No poses: it has no shape.
    void set_last(std::optional<Poses> poses, const Eigen::VectorXd& x);
    const std::optional<Poses>& last() const { return last_; }
    const Eigen::VectorXd& last_x() const { return last_x_; }
    /// The next level starts from the equilibrium of the last design.
    void accept() {
        if (last_ && !is_each_from_datum_) accepted_ = last_;
    }

    PrimoShell* shell() { return shell_.get(); }  ///< null: the problem has none
    /// At the equilibrium of the last shape, `surface` (n x 3), one adjoint solve each; without a shell what is left is
    /// `vertex`.
    /// `adjoint_of_vertices`, at the present equilibrium.
    std::vector<ShellSensitivities> adjoint_of_vertices(const std::vector<int>& vertices, const Points& dJ_dv,
                                                        const AdjointOptions& options);
    std::vector<ShellSensitivities> adjoint(const std::vector<Points>& dJ_dv, const AdjointOptions& options,
                                            const Points& surface);
    /// The surface of the last shape as the motion limit sees it, whose datum the planform moves.
    Points beside_planform(const Points& vertices) const;
    /// The shell is at the equilibrium of x.
    bool is_at(const Eigen::VectorXd& x) const { return shell_x_.size() == x.size() && shell_x_ == x; }

private:
    /// Where the equilibrium at x is sought from: the nearest (in the metric) of the shapes that this level has reached
    /// last, else the accepted one; none before the first evaluation of a run.
    const Poses* nearest_known(const Eigen::VectorXd& x) const;
    void build_shell(const ShellDemand& demand);
    void keep_border();
    bool solve(const Eigen::VectorXd& x, ShapeEvaluation& result);
    bool at_equilibrium(const Eigen::VectorXd& x, ShapeEvaluation& result);
    /// Of what `settle` gave last.
    const std::string& defect();
    std::string refusal_of(const Points& settled);  ///< the shape at the x of the last `settle`
    bool is_valid(const Eigen::VectorXd& x, ShapeEvaluation& result);
    void remember(const Eigen::VectorXd& x);

    std::shared_ptr<const RestFacts> rest_;
    ShapeGuard guard_;
    std::vector<int> held_;  ///< triangles that no design moves
    DesignSpace space_;
    std::function<bool()> stop_wanted_;
    std::unique_ptr<PrimoShell> shell_;
    std::vector<int> shell_pin_;
    Eigen::VectorXd shell_height_;
    Eigen::VectorXd shell_x_;   ///< of the equilibrium that the shell is at; empty: it is at none
    ShellDemand shell_demand_;  ///< of the same; where only the fields change, it is kept
    MotionLimit limit_;
    EdgeFolds border_, edges_and_border_;  ///< none: no border is kept
    std::string no_datum_;
    bool is_each_from_datum_ = false;
    Poses rest_poses_;                           ///< of `shell_`
    Eigen::VectorXd settled_x_;                  ///< of the last call of `settle`
    ShapeEvaluation settled_;                    ///< what it gave
    std::optional<std::string> settled_defect_;  ///< of that, once somebody asked
    Eigen::VectorXd last_x_;
    std::optional<Poses> accepted_, last_;
    struct KnownShape {
        Eigen::VectorXd x;
        Poses poses;
    };
    std::vector<KnownShape> known_;  ///< of this level, the latest last
};

}  // namespace strake
