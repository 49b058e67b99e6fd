#include "studio/bench_worker.hpp"

#include "core/error.hpp"
#include "report/json_number.hpp"

#include <chrono>
#include <cmath>

namespace strake {

BenchWorker::BenchWorker(std::function<Case(const std::string&)> load) : load_(std::move(load)) {
    thread_ = std::thread([this] { work(); });
}

BenchWorker::~BenchWorker() {
    {
        const std::lock_guard lock(busy_);
        ends_ = true;
    }
    called_.notify_all();
    thread_.join();
}

int BenchWorker::wish(Wish wish) {
    const std::lock_guard lock(busy_);
    waiting_ = std::move(wish);
    called_.notify_all();
    return ++asked_;
}

BenchWorker::State BenchWorker::state() {
    const std::lock_guard lock(busy_);
    State now = state_;
    if (!preview_) return now;
    now.num_modes = preview_->num_ready();
    now.has_envelope = preview_->envelope() != nullptr;
    now.mode_trouble = preview_->trouble();
    return now;
}

Points BenchWorker::shape(std::optional<int> wish) {
    const std::lock_guard lock(busy_);
    return !wish || *wish == state_.shape_of ? shape_ : Points(0, 3);
}
Points BenchWorker::downhill() {
    const std::lock_guard lock(busy_);
    return downhill_;
}
std::shared_ptr<const LinearPreview> BenchWorker::preview() const {
    const std::lock_guard lock(busy_);
    return preview_;
}

void BenchWorker::work() {
    for (;;) {
        Wish next;
        int number = 0;
        {
            std::unique_lock lock(busy_);
            called_.wait(lock, [&] { return ends_ || waiting_; });
            if (ends_) return;
            next = std::move(*waiting_);
            waiting_.reset();
            number = asked_;
            state_.is_busy = true;
        }
        Json made;
        try {
            made = answer(next, number);
        } catch (const std::exception& error) {
            made = {{"error", error.what()}};
        }
        const std::lock_guard lock(busy_);
        state_.answer = std::move(made);
        state_.done = number;
        state_.is_busy = waiting_.has_value();
    }
}

BenchWorker::Json BenchWorker::answer(const Wish& wish, int number) {
    if (!bench_ || bench_yaml_ != wish.yaml) {
        {
            const std::lock_guard lock(busy_);
            preview_.reset();
            shape_.resize(0, 3);
            downhill_.resize(0, 3);
            state_.shape_of = 0;
        }
        bench_.reset();
        bench_ = std::make_unique<ShapeBench>(load_(wish.yaml));
        bench_yaml_ = wish.yaml;
    }
    const int level = wish.level.value_or(bench_->coarsest());
    return wish.x ? shape_json(level, wish, number) : variables_json(level);
}

/// {levels: [first, last], level, variables: [{name, lower, upper, unit, is_parameter}], leaves_out_programs}.
BenchWorker::Json BenchWorker::variables_json(int level) {
    Json list = Json::array();
    for (const BenchVariable& variable : bench_->variables(level))
        list.push_back({{"name", variable.name},
                        {"lower", variable.lower},
                        {"upper", variable.upper},
                        {"unit", variable.unit},
                        {"is_parameter", variable.is_parameter}});
    auto preview = bench_->preview(level);
    const std::lock_guard lock(busy_);
    preview_ = std::move(preview);
    return {{"levels", {bench_->coarsest(), bench_->finest()}},
            {"level", level},
            {"variables", std::move(list)},
            {"leaves_out_programs", bench_->leaves_out_programs()}};
}

/// {status, reason, has_shape, shape_seconds, seconds, values: {name: value}, slope: {name, trouble, has} or null}. The
/// shape can be fetched before it is judged; where a newer wish waits then, it is not judged: status "overtaken".
BenchWorker::Json BenchWorker::shape_json(int level, const Wish& wish, int number) {
    const auto begin = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    double shape_seconds = std::nan("");
    bool has_shape = false;
    BenchShape made = bench_->at(level, *wish.x, [&](const Points& vertices) {
        const std::lock_guard lock(busy_);
        has_shape = true;
        shape_seconds = seconds();
        shape_ = vertices;
        state_.shape_of = number;
        ++state_.shapes;
        return !waiting_;
    });
    Json values = Json::object(), slope = nullptr;
    for (std::size_t k = 0; k < std::min(made.names.size(), made.values.size()); ++k)
        values[made.names[k]] = json_number(made.values[k]);
    Points downhill(0, 3);
    if (wish.wants_slope && made.vertices.rows() > 0) {
        ShapeBench::Slope found = bench_->slope(made.vertices);
        slope = {{"name", found.name}, {"trouble", found.trouble}, {"has", found.downhill.rows() > 0}};
        downhill = std::move(found.downhill);
    }
    const std::lock_guard lock(busy_);
    downhill_ = std::move(downhill);
    return {{"status", made.status},
            {"reason", made.reason},
            {"has_shape", has_shape},
            {"shape_seconds", json_number(shape_seconds)},
            {"seconds", json_number(seconds())},
            {"values", std::move(values)},
            {"slope", std::move(slope)}};
}

}  // namespace strake
