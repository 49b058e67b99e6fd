#include "studio/choice_json.hpp"

#include "core/error.hpp"

#include <cmath>
#include <numbers>

namespace strake {
namespace {

using Json = nlohmann::json;

double number_of(const Json& value, const char* what) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) throw InvalidInput(text(what, " must be a number"));
    return value.get<double>();
}

Eigen::Vector3d vector_of(const Json& value, const char* what) {
    if (!value.is_array() || value.size() != 3) throw InvalidInput(text(what, " must be three numbers"));
    return {number_of(value[0], what), number_of(value[1], what), number_of(value[2], what)};
}

int whole_of(const Json& value, const char* what, int end) {
    if (!value.is_number_integer()) throw InvalidInput(text(what, " must be a whole number"));
    const auto number = value.get<std::int64_t>();
    if (number < 0 || number >= end) throw InvalidInput(text(what, " ", number, " must be in [0, ", end, ")"));
    return static_cast<int>(number);
}

const Json& member(const Json& map, const char* key) {
    if (!map.is_object() || !map.contains(key)) throw InvalidInput(text("a step lacks '", key, "'"));
    return map[key];
}

std::string word_of(const Json& value, const char* what) {
    if (!value.is_string() || value.get_ref<const std::string&>().size() > 200)
        throw InvalidInput(text(what, " must be a name"));
    return value.get<std::string>();
}

FloodedRegion flood_of(const Json& value) {
    FloodedRegion flood;
    flood.point = vector_of(member(value, "point"), "flood: point");
    const double angle = number_of(member(value, "angle"), "flood: angle");
    if (angle < 0 || angle > 180) throw InvalidInput(text("flood: angle = ", angle, " must be in [0, 180]"));
    flood.angle = angle * std::numbers::pi / 180;
    return flood;
}

HalfSpace plane_of(const Json& value) {
    const Eigen::Vector3d normal = vector_of(member(value, "normal"), "plane: normal");
    if (!(normal.norm() > 1e-12)) throw InvalidInput("plane: the normal must not be zero");
    const Json& above = member(value, "above");
    if (!above.is_boolean()) throw InvalidInput("plane: above must be true or false");
    return {normal.normalized(), number_of(member(value, "at"), "plane: at"), above.get<bool>()};
}

SymmetryPlane mirror_of(const Json& value) {
    const Eigen::Vector3d normal = vector_of(member(value, "normal"), "mirror: normal");
    if (!(normal.norm() > 1e-12)) throw InvalidInput("mirror: the normal must not be zero");
    return {normal.normalized(), number_of(member(value, "offset"), "mirror: offset") / normal.norm()};
}

BoxShape box_of(const Json& value) {
    if (!value.is_array() || value.size() != 2) throw InvalidInput("box must be two corners");
    const BoxShape box{vector_of(value[0], "box: corner"), vector_of(value[1], "box: corner")};
    if ((box.min.array() > box.max.array()).any())
        throw InvalidInput("box: the first corner has the smaller coordinates");
    return box;
}

PickedTriangles triangles_of(const Json& value, int count) {
    if (!value.is_array()) throw InvalidInput("triangles must be a list");
    PickedTriangles picked;
    for (const Json& t : value) picked.triangles.push_back(whole_of(t, "triangle", count));
    return picked;
}

std::array<double, 2> range_of(const Json& value, const char* what) {
    if (!value.is_array() || value.size() != 2) throw InvalidInput(text(what, " must be two fractions"));
    const std::array<double, 2> range{number_of(value[0], what), number_of(value[1], what)};
    if (range[0] < 0 || range[1] > 1 || range[0] >= range[1])
        throw InvalidInput(text(what, " = [", range[0], ", ", range[1], "] must ascend within [0, 1]"));
    return range;
}

WingBox wing_box_of(const Json& value) {
    WingBox box{word_of(member(value, "of"), "wing: of"), range_of(member(value, "chord"), "wing: chord"),
                range_of(member(value, "span"), "wing: span")};
    const std::string side = value.contains("side") ? word_of(value["side"], "wing: side") : "both";
    if (side != "both" && side != "upper" && side != "lower")
        throw InvalidInput("wing: side must be both, upper or lower");
    box.side = side == "upper" ? 1 : side == "lower" ? -1 : 0;
    return box;
}

Combine combine_of(const Json& step) {
    const std::string op = step.contains("op") ? word_of(step["op"], "op") : "+";
    if (op == "+") return Combine::add;
    if (op == "-") return Combine::subtract;
    if (op == "&") return Combine::intersect;
    throw InvalidInput("op must be +, - or &");
}

ChoiceStep step_of(const Json& step, const TriMesh& mesh) {
    if (!step.is_object()) throw InvalidInput("a step must be an object");
    ChoiceStep made;
    made.combine = combine_of(step);
    if (step.contains("patch"))
        made.what = PatchShape{word_of(step["patch"], "patch")};
    else if (step.contains("part")) {
        const int part = whole_of(step["part"], "part", static_cast<int>(mesh.group_names.size()));
        made.what = SolidShape{mesh.group_names[static_cast<std::size_t>(part)]};
    } else if (step.contains("component"))
        made.what = ComponentShape{whole_of(step["component"], "component", mesh.num_triangles())};
    else if (step.contains("flood"))
        made.what = flood_of(step["flood"]);
    else if (step.contains("plane"))
        made.what = plane_of(step["plane"]);
    else if (step.contains("box"))
        made.what = box_of(step["box"]);
    else if (step.contains("triangles"))
        made.what = triangles_of(step["triangles"], mesh.num_triangles());
    else if (step.contains("all"))
        made.what = PickedAll{};
    else if (step.contains("grow"))
        made.what = GrowChoice{number_of(step["grow"], "grow")};
    else if (step.contains("invert"))
        made.what = InvertChoice{};
    else if (step.contains("mirror"))
        made.what = MirrorChoice{mirror_of(step["mirror"])};
    else if (step.contains("wing"))
        made.what = wing_box_of(step["wing"]);
    else if (step.contains("region"))
        made.what = DeclaredRegion{word_of(step["region"], "region")};
    else
        throw InvalidInput("a step names nothing to choose");
    return made;
}

}  // namespace

std::vector<ChoiceStep> choice_steps(const nlohmann::json& steps, const TriMesh& mesh) {
    constexpr std::size_t most = 200;
    if (!steps.is_array() || steps.size() > most) throw InvalidInput(text("steps must be a list of at most ", most));
    std::vector<ChoiceStep> made;
    for (const Json& step : steps) made.push_back(step_of(step, mesh));
    return made;
}

}  // namespace strake
