#include "report/drawing.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace strake {
namespace {

constexpr int fine = 2;  ///< samples a pixel in each direction

struct Frame {
    Points screen;  ///< n x 3: x to the right and y down in samples, z towards the eye
    Eigen::Vector3d right, up, eye;
    Eigen::Matrix<double, 2, 4> projection;  ///< (x, y, z, 1) to samples
};

Frame frame_of(const TriMesh& mesh, const View& view, int width, int height) {
    Frame f;
    f.eye = view.from.normalized();
    f.right = view.up.cross(f.eye);
    if (!(f.right.norm() > 1e-6 * view.up.norm()))
        throw InvalidInput("drawing: the view direction is parallel to `up`");
    f.right.normalize();
    f.up = f.eye.cross(f.right);
    Points p(mesh.num_vertices(), 3);
    p << mesh.vertices * f.right, -(mesh.vertices * f.up), mesh.vertices * f.eye;
    Eigen::RowVector3d low = Eigen::RowVector3d::Constant(1e300), high = -low;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            low = low.cwiseMin(p.row(mesh.triangles(t, k)));
            high = high.cwiseMax(p.row(mesh.triangles(t, k)));
        }
    const Eigen::RowVector3d size = (high - low).cwiseMax(1e-300), middle = (low + high) / 2;
    const double scale = (1 - 2 * view.margin) * std::min(width / size[0], height / size[1]);
    f.projection << scale * f.right.transpose(), width / 2.0 - scale * middle[0],  //
        -scale * f.up.transpose(), height / 2.0 - scale * middle[1];
    f.screen = (p.rowwise() - (low + high) / 2) * scale;
    f.screen.col(0).array() += width / 2.0;
    f.screen.col(1).array() += height / 2.0;
    return f;
}

/// The nearest triangle at each sample.
std::vector<int> visible(const TriMesh& mesh, const Frame& frame, int width, int height) {
    std::vector<int> seen(static_cast<std::size_t>(width) * height, -1);
    std::vector<float> depth(seen.size(), -std::numeric_limits<float>::infinity());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Eigen::RowVector3d a = frame.screen.row(mesh.triangles(t, 0)), b = frame.screen.row(mesh.triangles(t, 1)),
                                 c = frame.screen.row(mesh.triangles(t, 2));
        const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if (!(std::abs(area) > 1e-12)) continue;
        const int x0 = std::max(0, static_cast<int>(std::ceil(std::min({a[0], b[0], c[0]}) - 0.5)));
        const int x1 = std::min(width - 1, static_cast<int>(std::floor(std::max({a[0], b[0], c[0]}) - 0.5)));
        const int y0 = std::max(0, static_cast<int>(std::ceil(std::min({a[1], b[1], c[1]}) - 0.5)));
        const int y1 = std::min(height - 1, static_cast<int>(std::floor(std::max({a[1], b[1], c[1]}) - 0.5)));
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const double px = x + 0.5, py = y + 0.5;
                const double v = ((px - a[0]) * (c[1] - a[1]) - (py - a[1]) * (c[0] - a[0])) / area;
                const double w = ((b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0])) / area;
                if (v < 0 || w < 0 || v + w > 1) continue;
                const auto z = static_cast<float>(a[2] + v * (b[2] - a[2]) + w * (c[2] - a[2]));
                const std::size_t at = static_cast<std::size_t>(y) * width + x;
                if (z > depth[at]) depth[at] = z, seen[at] = t;
            }
    }
    return seen;
}

/// Light from above and a little from the left of the eye; both sides of a triangle count.
double shade(const Eigen::Vector3d& normal, const Frame& frame) {
    const Eigen::Vector3d light = (0.8 * frame.eye + 0.5 * frame.up - 0.3 * frame.right).normalized();
    return 0.42 + 0.58 * std::abs(normal.dot(light));
}

}  // namespace

Colour patch_colour(int number) {
    const double hue = std::fmod(0.58 + 0.6180339887498949 * number, 1.0) * 6;
    const double value = number % 3 == 0   ? 0.95
                         : number % 3 == 1 ? 0.78
                                           : 0.88,
                 saturation = number % 2 == 0 ? 0.55 : 0.8;
    Colour colour{};
    for (int k = 0; k < 3; ++k) {
        const double part = std::clamp(std::abs(std::fmod(hue + (k == 0 ? 0 : k == 1 ? 4 : 2), 6.0) - 3) - 1, 0.0, 1.0);
        colour[k] = static_cast<std::uint8_t>(std::lround(255 * value * (1 - saturation * (1 - part))));
    }
    return colour;
}

Colour signed_colour(double value) {
    // After ColorBrewer's PuOr and RdBu, as on the page of the report.
    constexpr std::array<Colour, 9> map{{{5, 48, 97},
                                         {33, 102, 172},
                                         {106, 172, 208},
                                         {191, 215, 230},
                                         {232, 232, 229},
                                         {239, 205, 166},
                                         {224, 146, 74},
                                         {179, 88, 6},
                                         {111, 47, 5}}};
    const double at = 4 * (std::clamp(std::isfinite(value) ? value : 0, -1.0, 1.0) + 1);
    const int k = std::min(7, static_cast<int>(at));
    Colour colour{};
    for (int c = 0; c < 3; ++c)
        colour[c] = static_cast<std::uint8_t>(std::lround(map[k][c] + (at - k) * (map[k + 1][c] - map[k][c])));
    return colour;
}

namespace {

/// What is seen at each sample, fine x fine of them a pixel.
struct Samples {
    const std::vector<int>& seen;  ///< triangles; -1: none
    const std::vector<int>& label;
    int w, h;

    int triangle(int x, int y) const { return seen[static_cast<std::size_t>(y) * w + x]; }
    int tag(int x, int y) const {
        const int t = triangle(x, y);
        return t < 0 ? -1 : label[t];
    }
    /// On the line between two labels, or at the outline.
    bool is_line(int u, int v) const {
        return (u + 1 < w && tag(u + 1, v) != tag(u, v)) || (v + 1 < h && tag(u, v + 1) != tag(u, v)) ||
               (u > 0 && tag(u - 1, v) == -1) || (v > 0 && tag(u, v - 1) == -1);
    }
};

/// Sum of the colours of a pixel's samples.
Eigen::Vector3d colours_of_pixel(const Samples& samples, const std::vector<Colour>& colour, const Points& normal,
                                 const Frame& frame, int x, int y) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int v = fine * y; v < fine * (y + 1); ++v)
        for (int u = fine * x; u < fine * (x + 1); ++u) {
            const int t = samples.triangle(u, v);
            if (t < 0) {
                sum += Eigen::Vector3d::Constant(255);
                continue;
            }
            const double light = samples.is_line(u, v) ? 0.15 : shade(normal.row(t), frame);
            for (int k = 0; k < 3; ++k) sum[k] += light * colour[t][k];
        }
    return sum;
}

/// Labels of a drawing's pixels: -1 none, -2 outside of the picture.
struct Tags {
    const Drawing& drawing;
    const std::vector<int>& label;

    int operator()(int x, int y) const {
        if (x < 0 || y < 0 || x >= drawing.width || y >= drawing.height) return -2;
        const int t = drawing.triangle[static_cast<std::size_t>(y) * drawing.width + x];
        return t < 0 ? -1 : label[t];
    }
};

/// Steps from each pixel to the nearest other label, by two passes over the picture.
std::vector<int> steps_to_border(const Tags& tag, int w, int h) {
    std::vector<int> inner(static_cast<std::size_t>(w) * h, w + h);
    const auto relax = [&](int x, int y, int dx, int dy) {
        int& here = inner[static_cast<std::size_t>(y) * w + x];
        const int other =
            tag(x + dx, y + dy) == tag(x, y) ? inner[static_cast<std::size_t>(y + dy) * w + x + dx] + 1 : 1;
        here = std::min(here, other);
    };
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) relax(x, y, -1, 0), relax(x, y, 0, -1);
    for (int y = h - 1; y >= 0; --y)
        for (int x = w - 1; x >= 0; --x) relax(x, y, 1, 0), relax(x, y, 0, 1);
    return inner;
}

}  // namespace

Drawing draw_surface(const TriMesh& mesh, const std::vector<Colour>& colour, const std::vector<int>& label,
                     const View& view, int width, int height) {
    const auto m = static_cast<std::size_t>(mesh.num_triangles());
    if (colour.size() != m || label.size() != m)
        throw InvalidInput(
            text("drawing: ", colour.size(), " colours and ", label.size(), " labels for ", m, " triangles"));
    if (width < 1 || height < 1 || width > 10000 || height > 10000)
        throw InvalidInput(text("drawing: ", width, " x ", height, " pixels must be in [1, 10000]"));
    if (!(view.margin >= 0 && view.margin < 0.5))
        throw InvalidInput(text("drawing: margin ", view.margin, " must be in [0, 0.5)"));
    const int w = fine * width, h = fine * height;
    const Frame frame = frame_of(mesh, view, w, h);
    const std::vector<int> seen = visible(mesh, frame, w, h);
    const Samples samples{seen, label, w, h};
    const Points normal = triangle_normals(mesh);
    Drawing drawing{width, height, {}, {}, frame.projection / fine};
    drawing.rgb.resize(3 * static_cast<std::size_t>(width) * height);
    drawing.triangle.resize(static_cast<std::size_t>(width) * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Eigen::Vector3d sum = colours_of_pixel(samples, colour, normal, frame, x, y);
            const std::size_t at = static_cast<std::size_t>(y) * width + x;
            for (int k = 0; k < 3; ++k)
                drawing.rgb[3 * at + k] = static_cast<std::uint8_t>(std::lround(sum[k] / (fine * fine)));
            drawing.triangle[at] = samples.triangle(fine * x, fine * y);
        }
    return drawing;
}

std::vector<Panel::Name> names_in(const Drawing& drawing, const std::vector<int>& label,
                                  const std::vector<std::string>& names, int min_pixels) {
    const int w = drawing.width, h = drawing.height;
    const Tags tag{drawing, label};
    const std::vector<int> inner = steps_to_border(tag, w, h);
    std::vector<int> best(names.size(), 0), count(names.size(), 0);
    std::vector<Panel::Name> at(names.size());
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            const int k = tag(x, y);
            if (k < 0 || k >= static_cast<int>(names.size())) continue;
            ++count[k];
            const int depth = inner[static_cast<std::size_t>(y) * w + x];
            if (depth > best[k]) best[k] = depth, at[k] = {x + 0.5, y + 0.5, names[k]};
        }
    std::vector<Panel::Name> found;
    for (std::size_t k = 0; k < names.size(); ++k)
        if (count[k] >= min_pixels && best[k] >= 5 && !names[k].empty()) found.push_back(at[k]);
    return found;
}

}  // namespace strake
