#pragma once
#include "core/remesh/working_mesh.hpp"

/// Wanted edge lengths, vertex by vertex. Internal to core/remesh.
namespace strake {

struct Sizing {
    double longest, shortest;  ///< wanted lengths lie between
    double gradation;          ///< change per distance
    /// Per point of the input, from its curvature; empty: uniform.
    std::vector<double> on_base;
    std::vector<char> bent;  ///< per point of the input: it would have to be shorter than `shortest`
};
/// @param chord_error > 0: l^2 / 8R is at most this; 0: uniform.
Sizing sizing_of(const BaseSurface& base, double longest, double shortest, double gradation, double chord_error);

/// The length beyond which longer edges are not to be had: 1.4 times the mean piece of a feature between two corners,
/// where so many pieces hold at least half of all vertices at that length; infinite elsewhere. Longer ones would hang
/// as needles on the short edges between corners, and be split again and again: more triangles, not fewer.
double longest_beside_features(const BaseSurface& base);

/// Points where the input, if it is remeshed already, may well have edges shorter than `longest`: its own ones turn the
/// normal as far as short ones may, and longest ones would turn it further; or they span a strip between two features;
/// or they lie on a curve that longer ones would leave by more than `slack`.
std::vector<char> tight_places(const BaseSurface& base, double longest, double slack);

/// Narrow strips between features, and whatever else leaves thin triangles, ask for shorter edges: notes them in
/// mesh.limit. @param everywhere also where no two features meet. @return how many vertices did.
int note_thin_places(WorkingMesh& mesh, const Sizing& sizing, bool everywhere);

/// The same for edges whose middles are farther from the input than `far`.
int note_far_edges(WorkingMesh& mesh, const Sizing& sizing, double far, int threads);

/// Sets mesh.size from the input's sizes and mesh.limit, graded.
void update_sizes(WorkingMesh& mesh, const Sizing& sizing);

}  // namespace strake
