#include "cases/geometry/closed_body.hpp"
#include "cases/geometry/lifting_body.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/aero/area_distribution.hpp"
#include "objectives/aero/friction.hpp"
#include "objectives/aero/newtonian.hpp"
#include "objectives/aero/projected_area.hpp"
#include "objectives/aero/wave_drag.hpp"
#include "objectives/geometry/bending.hpp"
#include "objectives/geometry/clearance.hpp"
#include "objectives/geometry/edge_radius.hpp"
#include "objectives/geometry/extent.hpp"
#include "objectives/geometry/mass_properties.hpp"
#include "objectives/geometry/measures.hpp"
#include "objectives/geometry/shape_change.hpp"
#include "objectives/geometry/thickness.hpp"
#include "objectives/geometry/wall_thickness.hpp"

#include <benchmark/benchmark.h>
#include <map>
#include <numbers>

/// A value of each quantity on a lifting body of 131 000 triangles, alone and with its gradient, and all that
/// cases/lifting_body/glide.yaml asks of an evaluation.
namespace {

const strake::TriMesh& body() {
    static const strake::TriMesh mesh = strake::example::lifting_body(131'000);
    return mesh;
}

std::vector<char> nose() {
    const strake::Points centroids = strake::triangle_centroids(body());
    std::vector<char> marks;
    for (int t = 0; t < body().num_triangles(); ++t) marks.push_back(centroids(t, 0) < 0.4);
    return marks;
}

std::map<std::string, strake::Quantity> quantities() {
    using namespace strake;
    NewtonianFlow plain;
    plain.stream.alpha.value = 0.14;
    plain.shadows = false;
    NewtonianFlow shadows = plain;
    shadows.shadows = true;
    NewtonianFlow leeward = plain;
    leeward.leeward = LeewardPressure::prandtl_meyer;
    WaveDrag oblique;
    oblique.mach = 1.4;
    FrictionFlow plates;
    plates.reynolds_per_length = 1e6;
    TriMesh inside = example::superellipsoid(2000, {{1, 0.3, 0.2}, 2});
    inside.vertices.col(0).array() += 5;
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
    return {{"volume", volume(body())},
            {"area", area()},
            {"newtonian", newtonian("q", body(), shadows)},
            {"newtonian_without_shadows", newtonian("q", body(), plain)},
            {"newtonian_prandtl_meyer", newtonian("q", body(), leeward)},
            {"wave_drag_mach_1", wave_drag("q", body(), {})},
            {"wave_drag_8_angles", wave_drag("q", body(), oblique)},
            {"friction", friction("q", body(), plates)},
            {"projected_area", projected_area("q", body(), {})},
            {"mass_properties", mass_properties("q", body())},
            {"extent", extent("q", body(), x, 0.01)},
            {"section_areas", section_areas("q", body(), x, 20)},
            {"wall_thickness", wall_thickness("q", body())},
            {"bending_energy", bending_energy("q", body())},
            {"fairness", fairness("q", body())},
            {"creases", creases("q", body(), 30 * std::numbers::pi / 180)},
            {"clearance", clearance("q", body(), inside, {"inside", Side::keep_out, 0.01, {}})},
            {"planarity", planarity("q", body())},
            {"symmetry_error", symmetry_error("q", body(), {Eigen::Vector3d::UnitY(), 0})},
            {"edge_radius", edge_radius("q", body(), nose())},
            {"displacement", displacement("q", body())}};
}

/// What glide.yaml names, with the values whose gradients its goal and constraints need.
std::vector<std::pair<strake::Quantity, std::vector<int>>> glide() {
    using namespace strake;
    NewtonianFlow flow;
    flow.stream.alpha.value = 8 * std::numbers::pi / 180;
    flow.moment_center = {4.05, 0, 0.1};
    flow.reference_area = 30;
    flow.reference_length = 8;
    FrictionFlow plate;
    plate.mach = 10;
    plate.reynolds_per_length = 8e5;
    plate.wall_temperature = 5;
    plate.reference_area = 30;
    std::vector<ThicknessLine> spars;
    for (const Eigen::Vector3d& at :
         {Eigen::Vector3d{2, 0, 0.1}, {4, 0, 0.1}, {6, 0, 0.1}, {4, 0.8, 0.05}, {6, 1, 0.05}, {7, 1.6, 0.05}})
        spars.push_back({at, Eigen::Vector3d::UnitZ(), {}});
    return {{newtonian("aero", body(), flow), {0, 1, 4}},
            {friction("plate", body(), plate), {0}},
            {thickness("spars", body(), spars, ThicknessValues::each), {0, 1, 2, 3, 4, 5}},
            {edge_radius("nose_radius", body(), nose(), SectionPlane{Eigen::Vector3d::UnitY(), 0.01}), {}},
            {projected_area("frontal", body(), {}), {}},
            {mass_properties("mass", body()), {}},
            {fairness("bumps", body()), {0}},
            {volume(body()), {0}}};
}

void evaluate_glide(benchmark::State& state) {
    const auto all = glide();
    for (auto _ : state)
        for (const auto& [quantity, wanted] : all) {
            strake::QuantityRequest request{body(), !wanted.empty(), 1, 0, {}};
            request.wanted.assign(quantity.names.size(), 0);
            for (const int i : wanted) request.wanted[static_cast<std::size_t>(i)] = 1;
            const strake::QuantityResult result = quantity.evaluate(request);
            if (result.failure) state.SkipWithError(result.failure->message.c_str());
            benchmark::DoNotOptimize(result.values.data());
        }
}

void evaluate(benchmark::State& state, const strake::Quantity& quantity, bool gradient) {
    strake::QuantityRequest request{body(), gradient, 1, 0, {}};
    request.wanted.assign(quantity.names.size(), 0);
    request.wanted[0] = 1;
    for (auto _ : state) {
        const strake::QuantityResult result = quantity.evaluate(request);
        if (result.failure) state.SkipWithError(result.failure->message.c_str());
        benchmark::DoNotOptimize(result.values.data());
    }
}

}  // namespace

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    const auto all = quantities();
    for (const auto& [name, quantity] : all)
        for (const bool gradient : {false, true})
            benchmark::RegisterBenchmark(
                (name + (gradient ? "/gradient" : "/value")).c_str(),
                [&quantity = quantity, gradient](benchmark::State& state) { evaluate(state, quantity, gradient); })
                ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark("glide", evaluate_glide)->Unit(benchmark::kMillisecond);
    benchmark::RunSpecifiedBenchmarks();
}
