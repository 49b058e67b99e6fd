#pragma once
#include "core/mesh/mesh.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// Pictures of surfaces without ParaView: a small orthographic renderer, PNG and SVG.
namespace strake {

using Colour = std::array<std::uint8_t, 3>;

/// Colours of patches, told apart also by colour-blind readers as far as numbers allow: hue by the golden ratio,
/// lightness in three steps.
Colour patch_colour(int number);

struct View {
    Eigen::Vector3d from;  ///< direction from the body to the eye; its length does not matter
    Eigen::Vector3d up;    ///< not along `from`
};

struct Drawing {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  ///< 3 width height, rows from the top; background white
    std::vector<int> triangle;      ///< per pixel the triangle that is seen, or -1
};

/// Draws the triangles in their colours, shaded, with dark lines where `label` changes between neighbouring pixels.
/// The body fills the frame. @param colour, label per triangle. @throws InvalidInput on sizes, a view along `up`.
Drawing draw_surface(const TriMesh& mesh, const std::vector<Colour>& colour, const std::vector<int>& label,
                     const View& view, int width, int height);

/// The drawing as a PNG file.
std::string png_bytes(const Drawing& drawing);

/// A panel of a picture: the drawing, what is written above it, and names at places of it.
struct Panel {
    Drawing drawing;
    std::string title;
    struct Name {
        double x, y;  ///< pixels of the drawing
        std::string words;
    };
    std::vector<Name> names;
};
struct LegendRow {
    Colour colour;
    std::string words;
};
/// One SVG with the panels beside each other, a title, and a legend below; opens in every browser.
std::string svg_picture(const std::string& title, const std::vector<Panel>& panels,
                        const std::vector<LegendRow>& legend);

/// Where each label is seen best: the pixel that is farthest from other labels, for labels of at least `least` pixels.
std::vector<Panel::Name> names_in(const Drawing& drawing, const std::vector<int>& label,
                                  const std::vector<std::string>& names, int least);

}  // namespace strake
