#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/text/file.hpp"
#include "optimize/run/stored_design.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

/// levels/best.design as bytes.
namespace strake {
namespace {

using Json = nlohmann::ordered_json;
using Named = std::vector<std::pair<std::string, double>>;

constexpr const char* first_line = "strake design 1\n";
const char* const byte_order = std::endian::native == std::endian::little ? "little" : "big";

template <class T>
void put(std::string& bytes, const T* data, std::size_t count) {
    bytes.append(reinterpret_cast<const char*>(data), sizeof(T) * count);
}

void put_ints(std::string& bytes, const std::vector<int>& values) {
    const std::vector<std::int32_t> exact(values.begin(), values.end());
    put(bytes, exact.data(), exact.size());
}

Json named(const Named& values) {
    Json j = Json::array();
    for (const auto& [name, value] : values) j.push_back({name, value});
    return j;
}

Json tree_json(const PatchHierarchy& tree) {
    Json levels = Json::array();
    for (const PatchLevel& level : tree.levels) {
        Json names = Json::array(), smooth = Json::array(), areas = Json::array();
        for (const Patch& patch : level.patches) {
            names.push_back(patch.name);
            smooth.push_back(patch.patch_class == PatchClass::smooth);
            areas.push_back(patch.area);
        }
        levels.push_back({{"angle_deg", level.angle_deg}, {"names", names}, {"smooth", smooth}, {"areas", areas}});
    }
    return levels;
}

std::vector<double> numbers(const RigidMotion& m) {
    return {m.rotation[0],    m.rotation[1], m.rotation[2], m.translation[0], m.translation[1],
            m.translation[2], m.about[0],    m.about[1],    m.about[2]};
}

/// Reads what `design_bytes` has written; whatever does not fit throws.
class Reader {
public:
    Reader(const std::string& bytes, std::size_t at) : bytes_(bytes), at_(at) {}
    std::vector<double> doubles(std::size_t count) { return values<double>(count); }
    std::vector<int> ints(std::size_t count, int least, int below) {
        const std::vector<std::int32_t> read = values<std::int32_t>(count);
        for (const int value : read)
            if (value < least || value >= below) throw InvalidInput(text("the number ", value, " is out of range"));
        return {read.begin(), read.end()};
    }
    Points points(int rows) {
        const std::vector<double> read = doubles(3 * static_cast<std::size_t>(rows));
        for (const double value : read)
            if (!std::isfinite(value)) throw InvalidInput("a number is not finite");
        return Eigen::Map<const Points>(read.data(), rows, 3);
    }
    bool is_at_end() const { return at_ == bytes_.size(); }

private:
    template <class T>
    std::vector<T> values(std::size_t count) {
        if (count > (bytes_.size() - at_) / sizeof(T)) throw InvalidInput("the file ends too early");
        std::vector<T> read(count);
        if (count > 0) std::memcpy(read.data(), bytes_.data() + at_, sizeof(T) * count);
        at_ += sizeof(T) * count;
        return read;
    }
    const std::string& bytes_;
    std::size_t at_;
};

PatchLevel level_of(const Json& j, std::vector<int> label, const PatchLevel* above) {
    PatchLevel level;
    level.angle_deg = j.at("angle_deg");
    for (std::size_t p = 0; p < j.at("names").size(); ++p) {
        Patch patch;
        patch.id = static_cast<int>(p);
        patch.name = j.at("names")[p];
        patch.patch_class = j.at("smooth").at(p).get<bool>() ? PatchClass::smooth : PatchClass::nonsmooth;
        patch.area = j.at("areas").at(p);
        level.patches.push_back(std::move(patch));
    }
    for (std::size_t t = 0; t < label.size(); ++t) level.patches[label[t]].triangles.push_back(static_cast<int>(t));
    for (Patch& patch : level.patches) {
        if (patch.triangles.empty()) throw InvalidInput(text("patch ", patch.name, " has no triangles"));
        if (above) patch.parent = above->label[patch.triangles.front()];
    }
    level.label = std::move(label);
    return level;
}

/// Named numbers of the head: pairs of a name and a value.
Named named_of(const Json& pairs) {
    Named values;
    for (const Json& v : pairs) values.emplace_back(v.at(0), v.at(1));
    return values;
}

/// Triangles of what is elastic: the surface's, or those of the wrap around it.
int elastic_triangles(const StoredDesign& d) { return static_cast<int>(d.tree.levels.front().label.size()); }

void read_tree(const Json& j, Reader& read, StoredDesign& d) {
    const int count = j.value("elastic_triangles", d.surface.triangles);
    if (count < 0) throw InvalidInput("a negative count");
    for (const Json& level : j.at("tree")) {
        std::vector<int> label = read.ints(count, 0, static_cast<int>(level.at("names").size()));
        d.tree.levels.push_back(level_of(level, label, d.tree.levels.empty() ? nullptr : &d.tree.levels.back()));
    }
    if (d.tree.levels.empty()) throw InvalidInput("it has no patches");
}

/// The patches of the design; together they cover what is elastic.
void read_front(const Json& j, StoredDesign& d) {
    std::vector<char> covered(static_cast<std::size_t>(elastic_triangles(d)), 0);
    for (const Json& patch : j.at("front")) {
        d.front.emplace_back(patch.at(0), patch.at(1));
        for (const int t : d.tree.levels.at(d.front.back().first).patches.at(d.front.back().second).triangles)
            if (std::exchange(covered[t], 1)) throw InvalidInput("two patches overlap");
    }
    if (std::find(covered.begin(), covered.end(), 0) != covered.end()) throw InvalidInput("a triangle has no patch");
}

void read_demand(const Json& j, Reader& read, StoredDesign& d) {
    const std::vector<double> dofs = j.at("freedoms");
    if (dofs.size() != patch_dof::count * d.front.size()) throw InvalidInput("a patch lacks its loads");
    d.dofs = Eigen::VectorXd::Map(dofs.data(), static_cast<Eigen::Index>(dofs.size()));
    for (const std::vector<double> v : j.at("motions"))
        d.carried_motion.push_back(
            {{v.at(0), v.at(1), v.at(2)}, {v.at(3), v.at(4), v.at(5)}, {v.at(6), v.at(7), v.at(8)}});
    d.given = named_of(j.at("given"));
    d.parameters = named_of(j.at("variables"));
    d.at_rest = named_of(j.at("at_rest"));
    if (!d.carried_motion.empty()) d.core = read.ints(elastic_triangles(d), -1, static_cast<int>(d.front.size()));
    if (!d.core.empty() && d.carried_motion.size() != d.front.size()) throw InvalidInput("a patch has no motion");
}

void read_shape(const Json& j, Reader& read, StoredDesign& d) {
    const int n = d.surface.vertices, m = elastic_triangles(d);
    if (j.value("shell", true)) {
        d.poses.displacement = read.points(m);
        const std::vector<double> q = read.doubles(4 * static_cast<std::size_t>(m));
        for (int t = 0; t < m; ++t) d.poses.rotation.emplace_back(q[4 * t], q[4 * t + 1], q[4 * t + 2], q[4 * t + 3]);
    }
    d.vertices = read.points(n);
    if (j.at("carried_traction")) d.carried_traction = read.points(m);
    if (j.at("carried_log_height")) {
        const std::vector<double> log_height = read.doubles(m);
        d.carried_log_height = Eigen::VectorXd::Map(log_height.data(), m);
    }
}

StoredDesign parse(const std::string& bytes) {
    const std::size_t begin = std::strlen(first_line), end = bytes.find('\n', begin);
    if (bytes.compare(0, begin, first_line) != 0 || end == std::string::npos)
        throw InvalidInput("this is not a stored design of this version");
    const Json j = Json::parse(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                               bytes.begin() + static_cast<std::ptrdiff_t>(end));
    if (j.at("byte_order") != byte_order) throw InvalidInput("written on a machine with another byte order");
    StoredDesign d;
    d.evaluation = j.at("evaluation"), d.level = j.at("level"), d.objective = j.at("objective");
    d.surface = {j.at("vertices"), j.at("triangles"), j.at("diagonal"), j.at("positions"), j.at("connectivity")};
    if (d.surface.vertices < 0 || d.surface.triangles < 0 || d.level < 0) throw InvalidInput("a negative count");
    Reader read(bytes, end + 1);
    read_tree(j, read, d);
    read_front(j, d);
    read_demand(j, read, d);
    read_shape(j, read, d);
    if (!read.is_at_end()) throw InvalidInput("the file is too long");
    return d;
}

}  // namespace

std::string design_bytes(const StoredDesign& d) {
    Json j;
    j["byte_order"] = byte_order;
    j["evaluation"] = d.evaluation, j["level"] = d.level, j["objective"] = d.objective;
    j["vertices"] = d.surface.vertices, j["triangles"] = d.surface.triangles, j["diagonal"] = d.surface.diagonal;
    j["positions"] = d.surface.positions, j["connectivity"] = d.surface.connectivity;
    j["tree"] = tree_json(d.tree);
    j["front"] = d.front;
    j["freedoms"] = std::vector<double>(d.dofs.data(), d.dofs.data() + d.dofs.size());
    j["motions"] = Json::array();
    for (const RigidMotion& motion : d.carried_motion) j["motions"].push_back(numbers(motion));
    j["given"] = named(d.given), j["variables"] = named(d.parameters), j["at_rest"] = named(d.at_rest);
    j["carried_traction"] = d.carried_traction.rows() > 0;
    j["carried_log_height"] = d.carried_log_height.size() > 0;
    if (d.poses.rotation.empty()) j["shell"] = false;
    if (elastic_triangles(d) != d.surface.triangles) j["elastic_triangles"] = elastic_triangles(d);
    std::string bytes = first_line + j.dump() + "\n";
    for (const PatchLevel& level : d.tree.levels) put_ints(bytes, level.label);
    put_ints(bytes, d.core);
    put(bytes, d.poses.displacement.data(), d.poses.displacement.size());
    for (const Eigen::Quaterniond& q : d.poses.rotation)
        for (const double value : {q.w(), q.x(), q.y(), q.z()}) put(bytes, &value, 1);
    put(bytes, d.vertices.data(), d.vertices.size());
    put(bytes, d.carried_traction.data(), d.carried_traction.size());
    put(bytes, d.carried_log_height.data(), d.carried_log_height.size());
    return bytes;
}

StoredDesign read_design(const std::filesystem::path& file) {
    const std::string bytes = read_bytes(file);
    try {
        return parse(bytes);
    } catch (const InvalidInput& refused) {
        throw InputError(text(file.string(), ": ", refused.what()));
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception&) {
        throw InputError(text(file.string(), ": the file is damaged"));
    }
}

}  // namespace strake
