#pragma once
#include "core/mesh/mesh.hpp"

#include <memory>

namespace strake {

/// A motion of all space that a surface carries with it, linear in the displacement of its n vertices: what a
/// `SurfaceMap` moves points by off the surface, if it is told of one.
class SpaceMotion {
public:
    virtual ~SpaceMotion() = default;
    virtual int num_vertices() const = 0;
    /// The amplitudes that come nearest to a displacement of the vertices (n x 3), and the transpose of that map.
    virtual Eigen::VectorXd fitted(const Points& displacement) const = 0;
    virtual Points fitted_transpose(const Eigen::VectorXd& by_amplitude) const = 0;

    /// The motion at points.
    class Field {
    public:
        virtual ~Field() = default;
        virtual Points displacement(const Eigen::VectorXd& amplitudes) const = 0;  ///< P x 3
        virtual Eigen::VectorXd transpose(const Points& by_displacement) const = 0;
    };
    virtual std::unique_ptr<const Field> at(const Points& points) const = 0;
};

}  // namespace strake
