#include "casefile/load_case.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "studio/studio_impl.hpp"
#include "studio/surface_payload.hpp"

#include <charconv>
#include <cstring>

/// Sliders: the variables of a level, what they do to first order, and the exact shape at their values.
namespace strake {

namespace {

template <class Number>
std::string bytes_of(const Number* values, std::size_t count) {
    std::string bytes(count * sizeof(Number), '\0');
    if (count > 0) std::memcpy(bytes.data(), values, bytes.size());
    return bytes;
}

WebAnswer numbers_answer(std::string bytes) { return {200, "application/octet-stream", std::move(bytes)}; }
WebAnswer nothing_there(const std::string& words) { return {404, "text/plain", words + "\n"}; }

BenchWorker::Wish wish_in(const nlohmann::json& asked) {
    BenchWorker::Wish wish{text_in(asked, "text"), {}, {}};
    if (asked.contains("level")) {
        if (!asked["level"].is_number_integer()) throw InvalidInput("'level' must be a whole number");
        const auto level = asked["level"].get<std::int64_t>();
        if (level < 0 || level > 1000) throw InvalidInput(text("level ", level, " must be in [0, 1000]"));
        wish.level = static_cast<int>(level);
    }
    if (!asked.contains("x")) return wish;
    if (!asked["x"].is_array()) throw InvalidInput("'x' must be a list");
    wish.x.emplace();
    for (const auto& value : asked["x"]) {
        if (!value.is_number()) throw InvalidInput("'x' must be a list of numbers");
        wish.x->push_back(value.get<double>());
    }
    wish.wants_slope = asked.value("slope", false);
    return wish;
}

}  // namespace

/// {wish}: its number. /api/felt_state tells when it is answered.
Studio::Impl::Json Studio::Impl::feel(const Asked& asked) {
    BenchWorker::Wish wish = wish_in(asked);
    const std::lock_guard lock(busy);
    if (!worker)
        worker = std::make_unique<BenchWorker>(
            [this](const std::string& yaml) { return load_case_text(yaml, case_path()); });
    return {{"wish", worker->wish(std::move(wish))}};
}

/// {done, is_busy, answer, shape_of, shapes, modes, envelope, trouble}.
Studio::Impl::Json Studio::Impl::felt_state() {
    BenchWorker* at_work = nullptr;
    {
        const std::lock_guard lock(busy);
        at_work = worker.get();
    }
    if (!at_work)
        return {{"done", 0},   {"is_busy", false}, {"answer", nullptr}, {"shape_of", 0},
                {"shapes", 0}, {"modes", 0},       {"envelope", false}};
    BenchWorker::State state = at_work->state();
    return {{"done", state.done},
            {"is_busy", state.is_busy},
            {"answer", std::move(state.answer)},
            {"shape_of", state.shape_of},
            {"shapes", state.shapes},
            {"modes", state.num_modes},
            {"envelope", state.has_envelope},
            {"trouble", state.mode_trouble}};
}

/// Arrays of the sliders: "shape" (as positions of /api/surface; of the wish `of`; nothing if that is not the last),
/// "slope" (n x 3), "envelope" (outward, then inward), "mode" (n x 3) of variable `j`.
WebAnswer Studio::Impl::felt(const std::string& what, const WebRequest& request) {
    const auto shown = need_subject();
    BenchWorker* at_work = nullptr;
    {
        const std::lock_guard lock(busy);
        at_work = worker.get();
    }
    const Eigen::Index vertices = shown->ground.start.mesh.num_vertices();
    const auto number = [&](const char* name) -> std::optional<int> {
        const auto stated = request.query.find(name);
        if (stated == request.query.end()) return {};
        int value = -1;
        std::from_chars(stated->second.data(), stated->second.data() + stated->second.size(), value);
        return value;
    };
    if (!at_work) return nothing_there("no variables were asked for");
    if (what == "shape") {
        const auto wish = number("of");
        const Points shape = at_work->shape(wish);
        if (wish && shape.rows() == 0) return numbers_answer("");  // the next one overtook it
        if (shape.rows() != vertices)
            return nothing_there("there is no shape, or it belongs to another surface than the one shown");
        return numbers_answer(centred_positions(shape, shown->ground.start.mesh));
    }
    if (what == "slope") {
        const std::vector<float> numbers = relative_to(Eigen::Vector3d::Zero(), at_work->downhill());
        if (static_cast<Eigen::Index>(numbers.size()) != 3 * vertices) return nothing_there("there is no slope");
        return numbers_answer(bytes_of(numbers.data(), numbers.size()));
    }
    const auto preview = at_work->preview();
    if (!preview) return nothing_there("not there yet");
    if (what == "envelope") {
        const auto envelope = preview->envelope();
        if (!envelope || envelope->outward.size() != vertices) return nothing_there("not there yet");
        const auto count = static_cast<std::size_t>(vertices);
        return numbers_answer(bytes_of(envelope->outward.data(), count) + bytes_of(envelope->inward.data(), count));
    }
    const auto mode = preview->mode(number("j").value_or(-1));
    if (!mode || static_cast<Eigen::Index>(mode->size()) != 3 * vertices) return nothing_there("not there yet");
    return numbers_answer(bytes_of(mode->data(), mode->size()));
}

std::string centred_positions(const Points& vertices, const TriMesh& start) {
    const Box box = bounding_box(start);
    const std::vector<float> positions = relative_to((box.min + box.max) / 2, vertices);
    return bytes_of(positions.data(), positions.size());
}

}  // namespace strake
