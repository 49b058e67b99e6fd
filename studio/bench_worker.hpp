#pragma once
#include "studio/shape_bench.hpp"

#include <condition_variable>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

/// The shell's own thread: shapes are computed there, and a newer wish overtakes those that have not begun.
namespace strake {

class BenchWorker {
public:
    using Json = nlohmann::ordered_json;
    /// @param load makes the case of a text; called by the worker's thread, and may throw.
    explicit BenchWorker(std::function<Case(const std::string& yaml)> load);
    ~BenchWorker();  ///< after the shape that is being computed
    BenchWorker(const BenchWorker&) = delete;
    BenchWorker& operator=(const BenchWorker&) = delete;

    struct Wish {
        std::string yaml;
        std::optional<int> level;              ///< nothing: the coarsest
        std::optional<std::vector<double>> x;  ///< nothing: only what variables there are
        bool wants_slope = false;              ///< of the objective, at this shape
    };
    /// Returns at once. @return number of the wish
    int wish(Wish wish);

    struct State {
        int done = 0;  ///< number of the last wish that is answered
        bool is_busy = false;
        Json answer;        ///< of that wish; {error: words} where it failed
        int shape_of = 0;   ///< number of the wish whose shape is there: before its answer, and while newer ones wait
        int shapes = 0;     ///< how many were there so far: a wish may get a second one in place of its first
        int num_modes = 0;  ///< variables whose first-order motion is there
        bool has_envelope = false;
        std::string mode_trouble;
    };
    State state();
    /// The last one, valid or not; empty: none. @param wish its number; nothing: whichever it is
    Points shape(std::optional<int> wish = {});
    Points downhill();                                     ///< of the last wish with a slope
    std::shared_ptr<const LinearPreview> preview() const;  ///< of the level asked for last; null: none yet

private:
    void work();
    Json answer(const Wish& wish, int number);
    Json variables_json(int level);
    Json shape_json(int level, const Wish& wish, int number);

    std::function<Case(const std::string&)> load_;
    std::unique_ptr<ShapeBench> bench_;  ///< of the thread alone
    std::string bench_yaml_;

    mutable std::mutex busy_;  ///< of all below
    std::condition_variable called_;
    std::optional<Wish> waiting_;
    int asked_ = 0;
    bool ends_ = false;
    State state_;
    Points shape_, downhill_;
    std::shared_ptr<const LinearPreview> preview_;
    std::thread thread_;  ///< last: it uses all others
};

}  // namespace strake
