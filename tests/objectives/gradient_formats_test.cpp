#include "core/error.hpp"
#include "core/formats/npy.hpp"
#include "core/formats/vtp.hpp"
#include "objectives/external/gradient.hpp"
#include "objectives/external/refused.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <cmath>

/// Gradient files of other programs: SU2's columns, VTP, NumPy.
namespace strake {
namespace {

const TriMesh sphere = icosphere(1);

Points wanted() {
    Points g(sphere.num_vertices(), 3);
    for (int v = 0; v < sphere.num_vertices(); ++v) g.row(v) << v, -0.5 * v, 1;
    return g;
}

std::string refusal(const std::string& bytes, const GradientPlaces& places, const std::string& field = "") {
    try {
        parse_gradient(bytes, "g", places, field);
    } catch (const Refused& refused) {
        return refused.failure.kind + ": " + refused.failure.message;
    }
    return "";
}
bool says(const std::string& words, const std::string& part) { return words.find(part) != std::string::npos; }

GradientPlaces vertices() { return vertices_of(sphere, 1e-5); }

/// As SU2 8 writes surface_sens.csv: quoted names, PointID of its own mesh, ten digits, any order.
std::string su2(const std::vector<std::string>& columns, bool shuffled, int first_id = 700) {
    std::string out;
    for (const std::string& name : columns) out += (out.empty() ? "\"" : ",\"") + name + "\"";
    out += "\n";
    const Points g = wanted();
    for (int i = 0; i < sphere.num_vertices(); ++i) {
        const int v = shuffled ? (i * 5 + 3) % sphere.num_vertices() : i;
        std::string row;
        for (const std::string& name : columns) {
            double value = 9;
            if (name == "PointID") value = first_id + v;
            for (int c = 0; c < 3; ++c) {
                if (name == std::string(1, "xyz"[c])) value = sphere.vertices(v, c);
                if (name == std::string("Sensitivity_") + "xyz"[c]) value = g(v, c);
            }
            if (name == "Surface_Sensitivity") value = -2.0 * v;
            row += (row.empty() ? "" : ", ") + text(value);
        }
        out += row + "\n";
    }
    return out;
}

const std::vector<std::string> su2_columns{
    "PointID", "x", "y", "z", "Sensitivity_x", "Sensitivity_y", "Sensitivity_z", "Surface_Sensitivity"};

TEST(GradientFormats, Su2ColumnsInAnyOrderAreMatchedByPlace) {
    ASSERT_EQ(sphere.num_vertices() % 5, 2) << "so that the rows are shuffled once each";
    EXPECT_EQ(parse_gradient(su2(su2_columns, true), "g", vertices()), wanted());
    EXPECT_EQ(
        parse_gradient(su2({"z", "Sensitivity_z", "y", "Sensitivity_y", "x", "Sensitivity_x"}, true), "g", vertices()),
        wanted());
}

TEST(GradientFormats, Su2NumbersAreFollowedWhereTheyAreKnown) {
    GradientPlaces places = vertices();
    for (int v = 0; v < sphere.num_vertices(); ++v) places.ids.push_back(700 + v);
    EXPECT_EQ(parse_gradient(su2(su2_columns, true), "g", places), wanted());
    const std::string other = refusal(su2(su2_columns, true, 701), places);
    EXPECT_TRUE(says(other, "from where it was handed over")) << other;
    const std::vector<std::string> without_place{"PointID", "Sensitivity_x", "Sensitivity_y", "Sensitivity_z"};
    EXPECT_EQ(parse_gradient(su2(without_place, true), "g", places), wanted());
    const std::string unknown = refusal(su2(without_place, true, 705), places);
    EXPECT_TRUE(says(unknown, "wrong_count: g:") && says(unknown, "no vertex with the number")) << unknown;
}

TEST(GradientFormats, NormalSensitivitiesPointIntoTheBody) {
    GradientPlaces places = vertices();
    const std::vector<std::string> columns{"PointID", "x", "y", "z", "Surface_Sensitivity"};
    EXPECT_TRUE(says(refusal(su2(columns, true), places), "missing_key")) << "no normals are known";
    places.normals = sphere.vertices;
    const Points g = parse_gradient(su2(columns, true), "g", places);
    for (int v = 0; v < sphere.num_vertices(); ++v)
        EXPECT_LT((g.row(v) - 2.0 * v * sphere.vertices.row(v)).norm(), 1e-12) << v;
}

TEST(GradientFormats, HeadersThatLackAColumnAreRefused) {
    EXPECT_TRUE(
        says(refusal(su2({"x", "y", "z", "Sensitivity_x", "Sensitivity_y"}, false), vertices()), "2 of the columns"));
    EXPECT_TRUE(says(refusal(su2({"x", "y", "Sensitivity_x", "Sensitivity_y", "Sensitivity_z"}, false), vertices()),
                     "neither x, y and z nor PointID"));
    EXPECT_TRUE(says(refusal(su2(su2_columns, false), vertices(), "dLift"), "missing_key: g:1: no columns 'dLift_x'"));
    std::string cut = su2(su2_columns, false);
    cut.resize(cut.rfind(','));
    EXPECT_TRUE(says(refusal(cut, vertices()), "7 columns, expected 8 as in the header"));
    const std::string missing = refusal(su2(su2_columns, false).substr(0, 600), vertices());
    EXPECT_NE(missing, "");
}

TEST(GradientFormats, NumpyRowsAreInTheOrderOfTheVertices) {
    EXPECT_EQ(parse_gradient(npy_bytes(wanted()), "g", vertices()), wanted());
    EXPECT_TRUE(
        says(refusal(npy_bytes(wanted().topRows(7)), vertices()), "wrong_count: g: 7 rows, the surface has 42"));
    Points bad = wanted();
    bad(5, 1) = std::nan("");
    EXPECT_TRUE(says(refusal(npy_bytes(bad), vertices()), "not_finite: g: row 5"));
    EXPECT_TRUE(says(refusal(npy_bytes(wanted()).substr(0, 90), vertices()), "unreadable: g: "));
}

TEST(GradientFormats, VtpFieldsAreMatchedByPlace) {
    std::vector<int> order;
    const TriMesh other = renumbered(sphere, 5, &order);
    Points permuted(sphere.num_vertices(), 3);
    for (int v = 0; v < sphere.num_vertices(); ++v) permuted.row(v) = wanted().row(order[static_cast<std::size_t>(v)]);
    const Eigen::VectorXd scalar = Eigen::VectorXd::Zero(sphere.num_vertices());
    const std::string one = vtp_bytes(other, {{"p", scalar}, {"dDrag", permuted}});
    EXPECT_EQ(parse_gradient(one, "g", vertices()), wanted());
    const std::string two = vtp_bytes(other, {{"dLift", other.vertices}, {"dDrag", permuted}});
    EXPECT_EQ(parse_gradient(two, "g", vertices(), "dDrag"), wanted());
    EXPECT_TRUE(says(refusal(two, vertices()), "2 point fields of vectors")) << refusal(two, vertices());
    EXPECT_TRUE(says(refusal(one, vertices(), "p"), "no point field 'p' of vectors"));
    EXPECT_TRUE(says(refusal(vtp_bytes(with_vertices(other, other.vertices * 1.001), {{"d", permuted}}), vertices()),
                     "wrong_count: g: row 0: no vertex within"));
    EXPECT_TRUE(says(refusal(one.substr(0, one.size() / 2), vertices()), "unreadable: "));
}

TEST(GradientFormats, VerticesThatCoincideAreToldApartByTheirOrder) {
    TriMesh seam = strip(1, 1, 1, 1);
    seam.vertices.row(1) = seam.vertices.row(0);
    std::string rows;
    for (int v = 0; v < seam.num_vertices(); ++v)
        rows += text(seam.vertices(v, 0), ",", seam.vertices(v, 1), ",", seam.vertices(v, 2), ",", v, ",0,0\n");
    const Points g = parse_gradient(rows, "g", vertices_of(seam, 1e-5));
    for (int v = 0; v < seam.num_vertices(); ++v) EXPECT_EQ(g(v, 0), v);
}

TEST(GradientFormats, TextThatIsNoTextIsRefused) {
    EXPECT_TRUE(says(refusal(std::string("0,1,2,3\n\0", 9), vertices()), "not text"));
    EXPECT_TRUE(says(refusal("<html>", vertices()), "unreadable: g"));
}

}  // namespace
}  // namespace strake
