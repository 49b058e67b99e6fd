#pragma once
#include "cli/run_strake.hpp"
#include "core/formats/io.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

/// Whole runs of the program with a small program of the test's own as objective.
namespace strake {

namespace fs = std::filesystem;
using Json = nlohmann::json;

inline void pause_ms(int milliseconds) { std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds)); }

/// A program that is started and then left to itself.
class Started {
public:
    /// @param prepare done in the child before it becomes the program.
    Started(const TempFolder& folder, const std::vector<std::string>& arguments,
            const std::function<void()>& prepare = {})
        : err_((folder / "err").string()) {
        std::vector<char*> argv{const_cast<char*>(STRAKE_PROGRAM)};
        for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
        argv.push_back(nullptr);
        fs::remove(err_);
        child_ = fork();
        if (child_ != 0) return;
        dup2(open("/dev/null", O_WRONLY), 1);
        dup2(open(err_.c_str(), O_WRONLY | O_CREAT, 0644), 2);
        if (prepare) prepare();
        execv(argv[0], argv.data());
        _exit(126);
    }
    void send(int number) const { kill(child_, number); }
    pid_t process() const { return child_; }
    bool has_ended() const {
        siginfo_t info{};
        return waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid != 0;
    }
    /// Exit status, 128 + signal when it did not exit.
    int wait() const {
        int status = 0;
        waitpid(child_, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    std::string messages() const { return bytes_of(err_); }

private:
    std::string err_;
    pid_t child_ = -1;
};

/// Writes the number of the evaluation to `calls`, then the volume of the surface, its gradient or both. As a
/// gradient_command it writes to `gradient-calls`, and looks for files gradient-sleep-1 and the like.
inline const char* const program = R"(import json, os, sys, time
here = os.path.dirname(os.path.abspath(__file__))
request = json.load(open(sys.argv[1]))
number = request["evaluation"]
result = sys.argv[2] if len(sys.argv) > 2 else "result.json"
kind = "gradient-" if os.path.basename(result).startswith("gradient") else ""
with open(here + "/" + kind + "calls", "a") as calls:
    calls.write("%d\n" % number)
def asked(what):
    return os.path.exists("%s/%s%s-%d" % (here, kind, what, number))
if asked("sleep"):
    if asked("deaf"):
        import signal
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    open(here + "/sleeping", "w").close()
    time.sleep(30 if asked("long") else 4)
if os.path.exists(here + "/jitter"):
    time.sleep(int.from_bytes(os.urandom(1), "little") / 10000)
if asked("fail"):
    sys.exit("licence server is down")
if asked("once"):
    os.remove("%s/once-%d" % (here, number))
    sys.exit(3)
p = [tuple(map(float, l.split()[1:4])) for l in open("surface.obj") if l.startswith("v ")]
total, g = 0.0, [[0.0, 0.0, 0.0] for _ in p]
for l in open("surface.obj"):
    if not l.startswith("f "):
        continue
    t = [int(w.split("/")[0]) - 1 for w in l.split()[1:4]]
    for i in range(3):
        a, b, c = p[t[i]], p[t[(i + 1) % 3]], p[t[(i + 2) % 3]]
        n = (b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0])
        if i == 0:
            total += (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]) / 6
        for k in range(3):
            g[t[i]][k] += n[k] / 6
if not request["wanted"]["gradients"]:
    with open("result.new", "w") as f:
        json.dump({"value": total}, f)
    os.rename("result.new", "result.json")
    sys.exit(0)
with open("g.csv", "w") as f:
    f.writelines("%d,%r,%r,%r\n" % (k, *row) for k, row in enumerate(g))
answer = {"gradient": "g.csv"} if kind else {"value": total, "gradient": "g.csv"}
with open(result + ".new", "w") as f:
    json.dump(answer, f)
os.rename(result + ".new", result)
)";

inline const std::string body =
    "surface: {file: s.obj}\nregions: {root: {box: [[-2, -2, -2], [-0.7, 2, 2]]}}\nfixed: [root]\n"
    "shell: {thickness: 5%}\nparameters: {patches_per_level: [2, 4], variables: [load]}\n";
inline const std::string by_program =
    "quantities: {bulk: {command: [python3, \"-S\", \"-E\", \"{case_dir}/bulk.py\", \"{request}\"] @}}\n"
    "objective: {maximize: bulk}\nconstraints: {area: {max: 1.02, relative: true}}\n";
inline const std::string gradients_apart =
    ", gradient_command: [python3, \"-S\", \"-E\", \"{case_dir}/bulk.py\", \"{request}\", \"{result}\"]";
inline const std::string built_in = "objective: {maximize: volume}\nconstraints: {area: {max: 1.02, relative: true}}\n";
inline const std::string budget = "optimize: {budget: {evaluations: 10}}\n";

/// A case whose objective a program measures, and runs of it.
class ProgramCase : public testing::Test {
protected:
    TempFolder folder;
    std::string path(const std::string& name) const { return (folder / name).string(); }

    void SetUp() override {
        write_surface(folder / "s.obj", ellipsoid({1, 0.6, 0.4}, 2), SurfaceFormat::obj);
        folder.write("bulk.py", program);
    }
    /// A case whose command has these further keys.
    std::string external_case(const std::string& more = "", const std::string& tail = budget) const {
        std::string text = body + by_program + tail;
        text.replace(text.find('@'), 1, more);
        return folder.write("case.yaml", text).string();
    }
    /// The run of `external_case()`, in `whole`: made once for all tests.
    void undisturbed() const {
        static const TempFolder once;
        if (!fs::exists(once / "whole")) {
            const ProgramRun run = run_strake({"run", external_case(), "--out", (once / "whole").string(), "-q"});
            ASSERT_EQ(run.status, 0) << run.err;
        }
        fs::copy(once / "whole", folder / "whole", fs::copy_options::recursive);
        fs::remove(folder / "calls");
    }
    void mark(const std::string& what) const { folder.write(what, ""); }
    std::multiset<int> calls(const std::string& file = "calls") const {
        std::multiset<int> all;
        std::istringstream lines(bytes_of(folder / file));
        for (int number; lines >> number;) all.insert(number);
        return all;
    }
    /// @param gradients_apart of b: none are asked for at the end, and the series may lack those of the last design.
    void expect_same(const std::string& a, const std::string& b, bool gradients_apart = false) const {
        for (const char* file : {"history.csv", "best.obj", "levels/best.csv", "levels/best.design", "series.pvd"}) {
            EXPECT_FALSE(bytes_of(folder / a / file).empty()) << file;
            EXPECT_EQ(bytes_of(folder / a / file), bytes_of(folder / b / file)) << file;
        }
        EXPECT_EQ(Json::parse(bytes_of(folder / a / "run.json"))["reason"],
                  Json::parse(bytes_of(folder / b / "run.json"))["reason"]);
        std::set<std::string> shapes[2];
        for (int k = 0; k < 2; ++k)
            for (const auto& entry : fs::directory_iterator(folder / (k == 0 ? a : b) / "series"))
                shapes[k].insert(entry.path().filename().string() + bytes_of(entry.path()));
        if (gradients_apart)
            for (auto& all : shapes) all.erase(std::prev(all.end()));
        EXPECT_FALSE(shapes[0].empty());
        EXPECT_TRUE(shapes[0] == shapes[1]);
        for (const auto& entry : fs::recursive_directory_iterator(folder / b))
            EXPECT_EQ(entry.path().string().find(".tmp"), std::string::npos) << entry.path();
        EXPECT_FALSE(fs::exists(folder / b / "lock"));
    }
    /// Evaluations that the journal in `out` has on record.
    std::set<int> recorded(const std::string& out) const {
        std::set<int> numbers;
        const ProgramRun told = run_strake({"history", path(out), "--csv"});
        std::istringstream rows(told.out);
        for (std::string row; std::getline(rows, row);)
            if (std::isdigit(static_cast<unsigned char>(row[0]))) numbers.insert(std::stoi(row));
        return numbers;
    }
};

}  // namespace strake
