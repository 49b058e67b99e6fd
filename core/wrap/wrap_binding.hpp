#pragma once
#include "core/mesh/mesh.hpp"

#include <functional>
#include <memory>
#include <vector>

/// How a body follows the wrap around it: a fixed linear map B from displacements of the wrap's vertices (n x 3) to
/// displacements of the body's (N x 3), and its exact transpose.
///
///     const WrapBinding binding(wrap, body.vertices, {held});
///     body_now = body.vertices + binding.displacement(wrap_now - wrap.vertices);
///     dJ_dwrap = binding.transpose(dJ_dbody);
///
/// B u = affine part + radial part + local part, one after another on what the ones before leave of u:
///   the affine map nearest to u, in the mean over the wrap's area;
///   sum_c a_c |x - x_c|^3 + b + A x, which interpolates the rest at up to 500 centres, each as far as possible from
///   those before it (Duchon 1977: the interpolant of least bending energy in space). Where these carry a motion of
///   second degree, 5 % of the diagonal at its ends, more than 2.5e-4 of the diagonal off at worst, 50 more are chosen
///   next to what is carried worst (squared distance times squared error), and so on, up to 1000;
///   a mean of the rest over the wrap's vertices nearby (Shepard weights, area times Wendland's function of the
///   distance over 2 edges plus 1.5 depths), fading out between 2 and 5 edges from the wrap.
/// Such a map is smooth where the body is not: neighbours of a crease, slivers and parts that pierce each other move
/// alike, where prisms and closest points of the wrap would tear them apart.
///
/// B 0 is 0, bit for bit. Affine maps are reproduced to round-off, except on what is held. It is not local: a bump
/// moves the body elsewhere by some 1e-3 of its height. A wing thinner than the distance of the centres moves with the
/// mean of its two sides: thickness does not go through a wrap.
namespace strake {

class CellSums;

/// How bodies that evaluate their radial functions add them up; all but the last: the bits of earlier runs.
enum class RadialSums { by_products, by_centers, by_boxes };

struct WrapBindingOptions {
    std::vector<char> held = {};  ///< per vertex of the body: does not move, B's row is zero; empty: none
    int centers = 500;            ///< at most so many, >= 4
    /// Per vertex of the wrap its mirror image, where it has a plane of symmetry: centres are chosen in pairs, so that
    /// symmetric displacements move a symmetric body symmetrically. Empty: none.
    std::vector<int> image = {};
    RadialSums sums = RadialSums::by_boxes;
    int max_centers = 1000;  ///< where these do not carry well; no more than `centers`: never
};

class WrapBinding {
public:
    /// @throws InvalidInput: no triangle or no area, a wrong size of `held`, fewer than four centers, a coordinate
    /// that is not finite; a wrap that lies in a plane.
    /// Cost: one LU of the number of centres (0.1 s) for each choice of them, and a search per vertex of the body. Of
    /// up to 16 000 vertices (64 MB; 128) the radial functions are kept, of more they are evaluated with each product:
    /// 0.1 s a million vertices.
    WrapBinding(const TriMesh& wrap, const Points& body, const WrapBindingOptions& options = {});
    ~WrapBinding();
    WrapBinding(WrapBinding&&) noexcept;
    WrapBinding& operator=(WrapBinding&&) noexcept;

    /// B u. @throws InvalidInput on a wrong size. Cost: centres times vertices of the body, and of the wrap where they
    /// are not kept.
    Points displacement(const Points& of_wrap) const;
    /// B^T g. The same cost.
    Points transpose(const Points& of_body) const;
    /// Of several at once, for less than one after another.
    std::vector<Points> transpose(const std::vector<Points>& of_body) const;
    /// Of functionals of one vertex of the body each, with the same bits, for little time and memory.
    /// @param of_body dJ/d(that vertex), a row each
    std::vector<Points> transpose_at(const std::vector<int>& vertex, const Points& of_body) const;
    /// Per point (n x 3): the linear part I + grad of the motion there, without that of the local part, which is small
    /// and no motion of its own. What is held is not looked at. Cost: centres times points.
    std::vector<Eigen::Matrix3d> local_maps(const Points& of_wrap, const Points& at) const;
    /// The same at points that are asked for again and again. @param at of this binding
    std::vector<Eigen::Matrix3d> local_maps(const Points& of_wrap, const CellSums& at) const;
    /// Handed on point by point, from several threads.
    void each_local_map(const Points& of_wrap, const CellSums& at,
                        const std::function<void(Eigen::Index point, const Eigen::Matrix3d& map)>& consume) const;
    std::shared_ptr<const CellSums> places(const Points& at) const;

    const std::vector<int>& centers() const;  ///< vertices of the wrap, in the order of choice
    double edge_length() const;               ///< mean edge of the wrap
    double largest_depth() const;             ///< of the body's vertices: distance from the wrap

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace strake
