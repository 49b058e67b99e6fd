#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/text/base64.hpp"
#include "report/drawing.hpp"

#include <fmt/format.h>
#include <zlib.h>
#include <algorithm>
#include <cmath>

namespace strake {
namespace {

void add_big_endian(std::string& out, std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 255);
}

void add_chunk(std::string& out, const std::string& kind, const std::string& data) {
    add_big_endian(out, static_cast<std::uint32_t>(data.size()));
    const std::string body = kind + data;
    out += body;
    add_big_endian(out, static_cast<std::uint32_t>(
                            ::crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

std::string xml(const std::string& words) {
    std::string out;
    for (const char c : words)
        out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
    return out;
}

std::string hex(const Colour& colour) { return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]); }

/// Words with a white rim, readable on any colour.
std::string label_at(double x, double y, const std::string& words, const char* anchor, const std::string& fill) {
    return fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"12\" text-anchor=\"{}\" stroke=\"white\" "
        "stroke-width=\"3\" paint-order=\"stroke\"{}>{}</text>\n",
        x, y, anchor, fill.empty() ? "" : " fill=\"" + fill + "\"", xml(words));
}

/// A line with a head; nothing where it points at the reader or away from him.
std::string arrow(const Panel::Arrow& arrow, double x, double y) {
    const std::string colour = hex(arrow.colour);
    const Eigen::Vector2d at(x, y), from = arrow.from + at, to = arrow.to + at, along = to - from;
    const double length = along.norm();
    if (!(length > 6)) return "";
    const Eigen::Vector2d u = along / length, v(-u[1], u[0]), neck = to - std::min(11.0, length / 2) * u;
    std::string out = fmt::format(
        "<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" stroke=\"white\" stroke-width=\"6\"/>"
        "<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" stroke=\"{}\" stroke-width=\"3\"/>"
        "<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}Z\" fill=\"{}\" stroke=\"white\"/>\n",
        from[0], from[1], neck[0], neck[1], from[0], from[1], neck[0], neck[1], colour, to[0], to[1],
        neck[0] + 6 * v[0], neck[1] + 6 * v[1], neck[0] - 6 * v[0], neck[1] - 6 * v[1], colour);
    if (arrow.words.empty()) return out;
    const Eigen::Vector2d beside = to + 8 * u + Eigen::Vector2d(0, 4);
    return out + label_at(beside[0], beside[1], arrow.words,
                          u[0] > 0.4    ? "start"
                          : u[0] < -0.4 ? "end"
                                        : "middle",
                          colour);
}

}  // namespace

std::string png_bytes(const Drawing& drawing) {
    std::string rows;
    const std::size_t stride = 3 * static_cast<std::size_t>(drawing.width);
    for (int y = 0; y < drawing.height; ++y) {
        rows += '\1';  // each byte minus that of the pixel to its left: compresses well
        const std::uint8_t* row = drawing.rgb.data() + y * stride;
        for (std::size_t k = 0; k < stride; ++k) rows += static_cast<char>(row[k] - (k >= 3 ? row[k - 3] : 0));
    }
    uLongf size = ::compressBound(rows.size());
    std::string packed(size, '\0');
    if (::compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
                    rows.size(), 9) != Z_OK)
        throw OutputError("drawing: cannot compress a PNG");
    packed.resize(size);
    std::string out = "\x89PNG\r\n\x1a\n", head;
    add_big_endian(head, static_cast<std::uint32_t>(drawing.width));
    add_big_endian(head, static_cast<std::uint32_t>(drawing.height));
    head += std::string("\x08\x02\x00\x00\x00", 5);
    add_chunk(out, "IHDR", head);
    add_chunk(out, "IDAT", packed);
    add_chunk(out, "IEND", "");
    return out;
}

namespace {

std::string tick(const Panel::Tick& tick, const Drawing& drawing, double x, double y) {
    const double bottom = y + drawing.height, at = tick.is_below ? x + tick.at : y + tick.at;
    if (tick.is_below)
        return fmt::format("<path d=\"M{0:.1f} {1:.1f}L{0:.1f} {2:.1f}\" stroke=\"#777\"/>\n", at, bottom - 6, bottom) +
               label_at(at, bottom - 9, tick.words, "middle", "#555");
    return fmt::format("<path d=\"M{0:.1f} {1:.1f}L{2:.1f} {1:.1f}\" stroke=\"#777\"/>\n", x, at, x + 6) +
           label_at(x + 9, at + 4, tick.words, "start", "#555");
}

std::string panel_at(const Panel& panel, int x, int top) {
    std::string out = fmt::format("<text x=\"{}\" y=\"{}\" font-size=\"14\" fill=\"#444\">{}</text>\n", x, top - 16,
                                  xml(panel.title));
    out +=
        fmt::format("<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" xlink:href=\"data:image/png;base64,{}\"/>\n",
                    x, top, panel.drawing.width, panel.drawing.height, base64(png_bytes(panel.drawing)));
    for (const Panel::Tick& one : panel.ticks) out += tick(one, panel.drawing, x, top);
    for (const Panel::Name& name : panel.names) out += label_at(x + name.x, top + name.y + 4, name.words, "middle", "");
    for (const Panel::Arrow& one : panel.arrows) out += arrow(one, x, top);
    return out;
}

constexpr double min_apart = 120;  ///< pixels of four steps

/// 1, 2 or 5 times a power of ten, of which some four fit.
double round_step(double length) {
    const double rough = length / 4, ten = std::pow(10.0, std::floor(std::log10(rough)));
    for (const double step : {1.0, 2.0, 5.0})
        if (step * ten >= rough) return step * ten;
    return 10 * ten;
}

}  // namespace

std::vector<Panel::Tick> ticks_of(const Drawing& drawing, const Box& box) {
    std::vector<Panel::Tick> ticks;
    for (int border = 0; border < 2; ++border) {
        const Eigen::RowVector3d by = drawing.projection.row(border).head<3>();
        int c = 0;
        const double most = by.cwiseAbs().maxCoeff(&c), length = box.max[c] - box.min[c];
        if (!(most > 0) || by.cwiseAbs().sum() > most * (1 + 1e-9) || !(length > 0)) continue;
        const double step = round_step(std::max(length, min_apart / most));
        const auto first = static_cast<long>(std::ceil(box.min[c] / step)),
                   last = std::min(first + 20, static_cast<long>(std::floor(box.max[c] / step)));
        for (long k = first; k <= last; ++k) {
            const double value = static_cast<double>(k) * step;
            const double at = by[c] * value + drawing.projection(border, 3);
            ticks.push_back({at, border == 0, fmt::format("{}{:.6g}", k == first ? text("xyz"[c], " = ") : "", value)});
        }
    }
    return ticks;
}

std::string svg_picture(const std::string& title, const std::vector<Panel>& panels,
                        const std::vector<LegendRow>& legend, int per_row) {
    constexpr int above = 46;  // the title of a row's panels
    const std::size_t columns =
        per_row > 0 ? static_cast<std::size_t>(per_row) : std::max<std::size_t>(1, panels.size());
    int width = 20, height = 32;
    std::string body;
    for (std::size_t first = 0; first < panels.size(); first += columns) {
        int x = 20, tallest = 0;
        for (std::size_t k = first; k < std::min(panels.size(), first + columns); ++k) {
            body += panel_at(panels[k], x, height + above);
            x += panels[k].drawing.width + 20;
            tallest = std::max(tallest, panels[k].drawing.height);
        }
        width = std::max(width, x);
        height += above + tallest;
    }
    const int legends = std::max(1, (width - 40) / 190);
    const int rows = (static_cast<int>(legend.size()) + legends - 1) / legends;
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{0}\" "
        "height=\"{1}\" "
        "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n"
        "<text x=\"20\" y=\"32\" font-size=\"20\">{2}</text>\n",
        width, height + 24 + 22 * rows, xml(title));
    out += body;
    for (std::size_t i = 0; i < legend.size(); ++i) {
        const int column = static_cast<int>(i) % legends, row = static_cast<int>(i) / legends;
        out += fmt::format(
            "<rect x=\"{}\" y=\"{}\" width=\"14\" height=\"14\" fill=\"{}\" stroke=\"#333\"/>"
            "<text x=\"{}\" y=\"{}\" font-size=\"13\">{}</text>\n",
            20 + 190 * column, height + 14 + 22 * row, hex(legend[i].colour), 40 + 190 * column, height + 26 + 22 * row,
            xml(legend[i].words));
    }
    return out + "</svg>\n";
}

}  // namespace strake
