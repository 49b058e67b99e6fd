#pragma once
#include "core/planform/wing.hpp"
#include "lofted_wing.hpp"

#include <cmath>
#include <numbers>

/// Wings of all kinds, alone and with bodies, for tests.
namespace strake {

struct WingBody {
    std::string name;
    TriMesh mesh;
    WingDeclaration declared;
    bool is_joined = false;
};

inline TriMesh both(const TriMesh& a, const TriMesh& b) {
    TriMesh all;
    all.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
    all.vertices << a.vertices, b.vertices;
    all.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
    all.triangles << a.triangles, Triangles(b.triangles.array() + static_cast<int>(a.vertices.rows()));
    return all;
}

/// A box across the plane y = 0, half of it, that holds the root of a wing.
inline TriMesh fuselage() {
    TriMesh box;
    box.vertices.resize(8, 3);
    for (int k = 0; k < 8; ++k) box.vertices.row(k) << (k & 1 ? 2.5 : -1), (k & 2 ? 0.4 : 0), (k & 4 ? 0.5 : -0.5);
    box.triangles.resize(10, 3);  // open at y = 0
    box.triangles << 2, 6, 3, 3, 6, 7, 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5;
    return box;
}

inline std::vector<WingBody> wing_bodies() {
    WingDeclaration half;
    half.symmetry = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    half.stations = {0, 0.4, 1};
    WingDeclaration whole = half;
    whole.symmetry.reset();
    std::vector<WingBody> all;
    Loft loft;
    loft.panels = 60;
    loft.cells = 25;
    all.push_back({"half", lofted(loft), half});
    all.push_back({"whole", lofted(loft, true), whole});
    all.push_back({"between rows", lofted(loft), half});
    all.back().declared.stations = {0, 0.33, 0.71, 1};
    Loft blunt = loft;
    blunt.blunt = 0.004;
    all.push_back({"blunt", lofted(blunt), half});
    Loft kinked = loft;
    kinked.chord = [](double s) { return s < 0.4 ? 1.4 - s : 1 - 0.5 * (s - 0.4); };
    kinked.quarter = [](double s) { return s < 0.4 ? 0.35 + 2 * s : 1.15 + 1.2 * (s - 0.4); };
    kinked.twist = [](double) { return 0.03; };  // its edges are straight
    all.push_back({"kinked", lofted(kinked), half});
    Loft upright = loft;
    upright.winglet = 0.2;
    upright.height = [](double) { return 0.0; };
    upright.cells = 50;
    all.push_back({"winglet", lofted(upright), half});
    all.back().declared.stations = {0, 0.4, 0.9};  // the tip's plane leaves the tip when this turns
    all.push_back({"body", both(fuselage(), lofted(loft)), half});
    for (int t = 0; t < all[0].mesh.num_triangles(); ++t) all.back().declared.triangles.push_back(10 + t);
    Loft slat = loft, flap = loft;
    slat.chord = [](double s) { return 0.15 * (1 - 0.5 * s); };
    slat.quarter = [](double s) { return -0.16 + 1.2 * s + 0.1 * s; };
    slat.height = [](double s) { return 0.3 * s - 0.02; };
    flap.chord = [](double s) { return 0.25 * (1 - 0.5 * s); };
    flap.quarter = [](double s) { return 1.1 + 0.76 * s; };
    flap.height = [](double s) { return 0.3 * s - 0.06; };
    all.push_back({"three elements", both(both(lofted(slat), lofted(loft)), lofted(flap)), half});
    // Joined: what lies within 12 % of the span is a body.
    WingBody joined{"joined", lofted(loft), half, true};
    for (int t = 0; t < joined.mesh.num_triangles(); ++t) {
        double low = 3;
        for (const int v : joined.mesh.triangles.row(t)) low = std::min(low, joined.mesh.vertices(v, 1));
        if (low > 0.36 - 1e-9) joined.declared.triangles.push_back(t);
    }
    joined.declared.stations = {0, 0.5, 1};  // on rows of the mesh
    all.push_back(joined);
    return all;
}

/// Half a wing whose outer fifth stands upright, behind a bend: what lies outboard of it is wound on an arc first.
inline WingBody bent_up() {
    constexpr double begin = 2.3, radius = 0.25, angle = 80 * std::numbers::pi / 180, end = begin + radius * angle;
    WingBody body = wing_bodies()[0];
    body.name = "winglet";
    body.declared.stations = {0, 0.4, 0.92, 1};
    for (int v = 0; v < body.mesh.num_vertices(); ++v) {
        const double y = body.mesh.vertices(v, 1), z = body.mesh.vertices(v, 2) - 0.1 * y;  // its dihedral
        if (y < begin) {
            body.mesh.vertices(v, 2) = z;
            continue;
        }
        const double a = (std::min(y, end) - begin) / radius, beyond = std::max(0.0, y - end);
        body.mesh.vertices(v, 1) = begin + (radius - z) * std::sin(a) + beyond * std::cos(a);
        body.mesh.vertices(v, 2) = radius - (radius - z) * std::cos(a) + beyond * std::sin(a);
    }
    return body;
}

}  // namespace strake
