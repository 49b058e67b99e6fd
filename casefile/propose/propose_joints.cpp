#include "casefile/propose/propose_parts.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/repair/joint_gap.hpp"
#include "core/repair/repair.hpp"

#include <algorithm>
#include <iomanip>
#include <locale>
#include <sstream>

/// Long edges where parts pass through each other open the joints under any smooth motion that bends. Shorter ones are
/// offered only where a bend shows that they help.
namespace strake::proposing {
namespace {

constexpr double bend = 0.05;             ///< diagonals, at both ends
constexpr double closed = 1e-4;           ///< diagonals: such a gap is none
constexpr double pays = 0.1;              ///< of the gap may be left
constexpr double max_times = 4;           ///< as many triangles
constexpr int few = 20000;                ///< so many are no burden, however few there were
constexpr double lengths[] = {1.0, 2.0};  ///< percent of the diagonal

/// Both ends of the longest extent toward the shortest one.
Points bent(const TriMesh& mesh) {
    const Box box = bounding_box(mesh);
    const Eigen::Vector3d size = box.max - box.min;
    const double diagonal = size.norm();
    Eigen::Index along = 0, toward = 0;
    size.maxCoeff(&along);
    size.minCoeff(&toward);
    if (toward == along) toward = (along + 1) % 3;
    const double middle = 0.5 * (box.min[along] + box.max[along]), half = 0.5 * size[along];
    Points moved = mesh.vertices;
    moved.col(toward).array() += bend * diagonal * ((mesh.vertices.col(along).array() - middle) / half).square();
    return moved;
}

double gap(const TriMesh& mesh, const std::vector<std::array<int, 2>>& pairs) {
    return joint_gap(mesh, pairs, bent(mesh)) / box_diagonal(mesh);
}

}  // namespace

std::optional<JointTrial> tried_joints(const TriMesh& mesh, const std::optional<Intersections>& pairs) {
    if (!pairs || pairs->apart.empty()) return {};
    JointTrial trial;
    trial.before = gap(mesh, pairs->apart);
    if (!(trial.before > closed)) return {};
    for (const double percent : lengths) {
        RepairOptions options;
        options.joints = percent / 100 * box_diagonal(mesh);
        RepairResult halved;
        try {
            halved = repair(mesh, options);
        } catch (const InvalidInput&) {  // millions of triangles
            continue;
        }
        trial.percent = percent;
        trial.triangles = halved.mesh.num_triangles();
        if (trial.triangles > std::max<double>(few, max_times * mesh.num_triangles()) || !halved.after.pairs) continue;
        trial.after = gap(halved.mesh, halved.after.pairs->apart);
        if (trial.after <= pays * trial.before) return trial;
    }
    return {};
}

std::string joint_words(const JointTrial& tried) {
    std::ostringstream words;
    words.imbue(std::locale::classic());
    words << std::setprecision(2) << "a bend of " << 100 * bend << " % of the diagonal opens joints by " << tried.after
          << " of it (" << tried.before << " as they are); " << tried.triangles << " triangles";
    return words.str();
}

}  // namespace strake::proposing
