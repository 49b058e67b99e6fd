#pragma once
#include "core/mesh/geometry.hpp"
#include "core/mesh/mesh.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// Pictures of surfaces without ParaView: a small orthographic renderer, PNG and SVG.
namespace strake {

using Colour = std::array<std::uint8_t, 3>;

/// Colours of patches, distinguishable for colour-blind readers as far as their number allows: hue by the golden ratio,
/// lightness in three steps.
Colour patch_colour(int number);

struct View {
    Eigen::Vector3d from;  ///< direction from the body to the eye; its length does not matter
    Eigen::Vector3d up;    ///< not along `from`
    double margin = 0.04;  ///< share of the frame that stays free on each side of the body, in [0, 0.49]
};

struct Drawing {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  ///< 3 width height, rows from the top; background white
    std::vector<int> triangle;      ///< for each pixel the visible triangle, or -1
    Eigen::Matrix<double, 2, 4> projection = Eigen::Matrix<double, 2, 4>::Zero();  ///< (x, y, z, 1) to pixels

    Eigen::Vector2d pixel_of(const Eigen::Vector3d& point) const { return projection * point.homogeneous(); }
};

/// Draws the triangles in their colours, shaded, with dark lines where `label` changes between neighbouring pixels.
/// The body fills the frame. @param colour, label per triangle. @throws InvalidInput on sizes, a view along `up`.
Drawing draw_surface(const TriMesh& mesh, const std::vector<Colour>& colour, const std::vector<int>& label,
                     const View& view, int width, int height);

/// The drawing as a PNG file.
std::string png_bytes(const Drawing& drawing);

/// -1 blue, 0 pale grey, 1 brown: a signed value, distinguishable with any colour vision.
Colour signed_colour(double value);

/// A panel of a picture: the drawing, its title, labels at points of it, and arrows.
struct Panel {
    Drawing drawing = {};
    std::string title = {};
    struct Name {
        double x, y;  ///< pixels of the drawing
        std::string words;
    };
    std::vector<Name> names = {};
    struct Arrow {
        Eigen::Vector2d from, to;  ///< pixels of the drawing
        Colour colour;
        std::string words;  ///< beside its end; may be empty
    };
    std::vector<Arrow> arrows = {};
    /// A mark at the lower or the left border of the drawing, with the coordinate that it stands for.
    struct Tick {
        double at;  ///< pixels along that border
        bool is_below;
        std::string words;
    };
    std::vector<Tick> ticks = {};
};

/// Marks at round coordinates along the borders of a view along a coordinate direction, within the box of what is
/// drawn; none along a border that is at an angle to the coordinate directions.
std::vector<Panel::Tick> ticks_of(const Drawing& drawing, const Box& box);
struct LegendRow {
    Colour colour;
    std::string words;
};
/// One SVG with a title, the panels in rows of `per_row`, and a legend below; opens in every browser.
/// @param per_row 0: all side by side
std::string svg_picture(const std::string& title, const std::vector<Panel>& panels,
                        const std::vector<LegendRow>& legend, int per_row = 0);

/// The best place for each label: the pixel farthest from other labels, for labels of at least `min_pixels` pixels.
std::vector<Panel::Name> names_in(const Drawing& drawing, const std::vector<int>& label,
                                  const std::vector<std::string>& names, int min_pixels);

}  // namespace strake
