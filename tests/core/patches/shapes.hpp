#pragma once
#include "core/patches/hierarchy.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

/// Surfaces and comparisons that only the tests of core/patches need.
namespace strake {

inline TriMesh mesh_of(const std::vector<Eigen::Vector3d>& points, const std::vector<std::array<int, 3>>& triangles) {
    TriMesh mesh;
    mesh.vertices.resize(points.size(), 3);
    mesh.triangles.resize(triangles.size(), 3);
    for (std::size_t i = 0; i < points.size(); ++i) mesh.vertices.row(i) = points[i];
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (int k = 0; k < 3; ++k) mesh.triangles(i, k) = triangles[i][k];
    return mesh;
}

/// Two rectangular plates of `cells` x `cells` squares meeting along y at the origin, exterior angle `dihedral_deg`.
inline TriMesh two_plates(double dihedral_deg, int cells) {
    std::vector<Eigen::Vector3d> points;
    std::vector<std::array<int, 3>> triangles;
    const double a = dihedral_deg * std::numbers::pi / 180;
    for (int i = -cells; i <= cells; ++i)
        for (int j = 0; j <= cells; ++j) {
            const double s = static_cast<double>(i) / cells, y = static_cast<double>(j) / cells;
            points.push_back(i <= 0 ? Eigen::Vector3d(s, y, 0) : Eigen::Vector3d(s * std::cos(a), y, -s * std::sin(a)));
        }
    const int n = cells + 1;
    for (int i = 0; i < 2 * cells; ++i)
        for (int j = 0; j < cells; ++j) {
            const int p = i * n + j;
            triangles.insert(triangles.end(), {{p, p + n, p + n + 1}, {p, p + n + 1, p + 1}});
        }
    return mesh_of(points, triangles);
}

/// Straight NACA 0012 wing of unit chord with a sharp trailing edge, x downstream, span along y from 0 to `span`;
/// `panels` cosine-spaced panels a side, `strips` along the span, open ends. Points of station s, panel p on the upper
/// side: s * 2 panels + p; p = 0 is the trailing edge, p = panels the leading edge, then the lower side.
inline TriMesh naca0012_wing(int panels, int strips, double span = 3) {
    const auto half_thickness = [](double x) {
        return 0.6 *
               (0.2969 * std::sqrt(x) - 0.1260 * x - 0.3516 * x * x + 0.2843 * x * x * x - 0.1036 * x * x * x * x);
    };
    const int around = 2 * panels;
    std::vector<Eigen::Vector3d> points;
    for (int s = 0; s <= strips; ++s)
        for (int p = 0; p < around; ++p) {
            const int q = p <= panels ? p : around - p;
            const double x = 0.5 * (1 + std::cos(std::numbers::pi * q / panels));
            const double z = q == 0 ? 0 : half_thickness(x);
            points.emplace_back(x, span * s / strips, p <= panels ? z : -z);
        }
    std::vector<std::array<int, 3>> triangles;
    for (int s = 0; s < strips; ++s)
        for (int p = 0; p < around; ++p) {
            const int a = s * around + p, b = s * around + (p + 1) % around, c = b + around, d = a + around;
            triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}});
        }
    return mesh_of(points, triangles);
}

/// A sphere with bumps of a few wavelengths: creases of every angle, patches of every size.
inline TriMesh bumpy(TriMesh mesh, double height) {
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Eigen::Vector3d p = mesh.vertices.row(v);
        mesh.vertices.row(v) *= 1 + height * (std::sin(9 * p.x() + 1) * std::sin(8 * p.y() + 2) * std::sin(7 * p.z()) +
                                              std::abs(std::sin(3 * p.x() - 2 * p.y())));
    }
    return mesh;
}

inline TriMesh moved_rigidly(TriMesh mesh) {
    const Eigen::Matrix3d R = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    mesh.vertices = ((mesh.vertices * R.transpose()).rowwise() + Eigen::RowVector3d(3, -40, 7)).eval();
    return mesh;
}

/// Whether two labellings are the same partition.
inline bool same_partition(const std::vector<int>& a, const std::vector<int>& b) {
    std::map<int, int> to, from;
    for (std::size_t t = 0; t < a.size(); ++t)
        if (to.try_emplace(a[t], b[t]).first->second != b[t] || from.try_emplace(b[t], a[t]).first->second != a[t])
            return false;
    return a.size() == b.size();
}

/// What every hierarchy obeys: labels match patches, numbering by smallest triangle, one parent each, areas add up,
/// names are unique but for a single child, which keeps its parent's. Empty, or what is wrong.
inline std::string broken_rule(const PatchHierarchy& tree) {
    std::map<std::string, std::vector<int>> owner;
    for (std::size_t l = 0; l < tree.levels.size(); ++l) {
        const PatchLevel& level = tree.levels[l];
        int last = -1;
        std::size_t total = 0;
        std::set<std::string> names;
        for (std::size_t p = 0; p < level.patches.size(); ++p) {
            const Patch& patch = level.patches[p];
            if (patch.id != static_cast<int>(p)) return "id";
            if (patch.triangles.empty() || patch.triangles.front() <= last) return "order of the smallest triangle";
            last = patch.triangles.front();
            total += patch.triangles.size();
            for (const int t : patch.triangles) {
                if (level.label[t] != patch.id) return "label";
                if (l > 0 && tree.levels[l - 1].label[t] != patch.parent) return "nesting";
            }
            if (!names.insert(patch.name).second) return "name twice on a level: " + patch.name;
            if (owner.try_emplace(patch.name, patch.triangles).first->second != patch.triangles)
                return "name used again: " + patch.name;
        }
        if (total != level.label.size()) return "triangles left out";
    }
    return "";
}

}  // namespace strake
