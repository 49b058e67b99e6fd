#include "casefile/load_case.hpp"
#include "casefile/yaml/value.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/text/file.hpp"
#include "studio/file_places.hpp"
#include "studio/studio_impl.hpp"

#include <algorithm>

/// Files of the folder: what may be opened, reading it, saving the case.
namespace strake {

namespace fs = std::filesystem;

namespace {

bool is_case(const fs::path& file) { return file.extension() == ".yaml" || file.extension() == ".yml"; }

bool is_surface(const fs::path& file) {
    try {
        format_of(file.extension() == ".gz" ? file.stem() : file);
        return true;
    } catch (const InvalidInput&) {
        return false;
    }
}

bool is_run(const fs::path& folder) {
    std::error_code ignored;
    return fs::is_directory(folder, ignored) && fs::exists(folder / "journal.sqlite", ignored);
}

}  // namespace

/// What a name of the page means, links followed. @throws InvalidInput: it is not in the folder.
fs::path Studio::Impl::inside(const std::string& name) const {
    std::error_code error;
    if (name.empty() || name.size() > 1000 || name.find('\0') != std::string::npos) throw InvalidInput("no such file");
    const fs::path path = fs::weakly_canonical(folder / name, error);
    if (error || !lies_in(path, folder)) throw InvalidInput("that is outside of the folder of this studio");
    return path;
}

Studio::Impl::Json Studio::Impl::files() const {
    Json cases = Json::array(), surfaces = Json::array(), runs = Json::array();
    std::vector<fs::path> paths;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) paths.push_back(entry.path());
    for (const auto& entry : fs::directory_iterator(folder / "runs", ignored))
        if (is_run(entry.path()) && lies_in(entry.path(), folder)) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    for (const fs::path& path : paths) {
        const std::string name = fs::relative(path, folder, ignored).string();
        if (is_run(path))
            runs.push_back(name);
        else if (fs::is_regular_file(path, ignored) && is_case(path))
            cases.push_back(name);
        else if (fs::is_regular_file(path, ignored) && is_surface(path))
            surfaces.push_back(name);
    }
    return {{"folder", folder.string()}, {"cases", cases}, {"surfaces", surfaces}, {"runs", runs}};
}

void Studio::Impl::open_later(const fs::path& file) {
    {
        const std::lock_guard lock(busy);
        to_open = file;
        is_opening = true;
    }
    wanted.notify_all();
}

void Studio::Impl::read_targets() {
    for (;;) {
        fs::path file;
        {
            std::unique_lock lock(busy);
            wanted.wait(lock, [&] { return ends || !to_open.empty(); });
            if (ends) return;
            file.swap(to_open);
        }
        std::string failed;
        try {
            open_now(file);
        } catch (const std::exception& error) {
            failed = error.what();
        }
        const std::lock_guard lock(busy);
        trouble = failed;
        ++version;
        is_opening = !to_open.empty();
    }
}

void Studio::Impl::open_now(const fs::path& file) {
    if (is_run(file)) {
        auto watch = std::make_shared<RunWatch>(file);
        {
            const std::lock_guard lock(busy);
            run = std::move(watch);
        }
        return open_case(file / "case.yaml");
    }
    if (is_case(file)) return open_case(file);
    auto made = surface_subject(file);
    const std::lock_guard lock(busy);
    subject = std::move(made);
    case_file.clear();
    case_text.clear();
}

/// A case that has errors is open in the editor without its surface.
void Studio::Impl::open_case(const fs::path& file) {
    const std::string yaml = read_case_file(file.string());
    std::shared_ptr<const Subject> before;
    {
        const std::lock_guard lock(busy);
        before = subject;
        if (file != case_file) subject = nullptr;
        case_file = file;
        case_text = yaml;
    }
    if (before && before->case_file == file && before->blocks == ground_blocks(yaml)) return;
    const auto show = [&](std::shared_ptr<const Subject> made) {
        const std::lock_guard lock(busy);
        subject = std::move(made);
    };
    try {
        show(case_subject(file, yaml));
    } catch (const std::exception&) {
        // What keeps the case from using its surface is easier to see on it.
        const Case the_case = load_case_text(yaml, file);
        show(surface_subject(the_case.surface));
        throw;
    }
}

/// {mark}: saved; {changed: true, text, mark}: another program has changed the file since the page read it.
Studio::Impl::Json Studio::Impl::save(const Asked& asked) {
    const std::string yaml = text_in(asked, "text"), mark = text_in(asked, "mark");
    if (yaml.size() > max_case_bytes) throw InvalidInput(text("a case has at most ", max_case_bytes, " bytes"));
    fs::path file;
    {
        const std::lock_guard lock(busy);
        file = case_file;
    }
    const bool is_new = asked.contains("name");
    if (is_new) file = inside(text_in(asked, "name"));
    if (file.empty() || !is_case(file) || !lies_in(file, folder)) throw InvalidInput("a case's name ends in .yaml");
    std::error_code ignored;
    const bool exists = fs::exists(fs::symlink_status(file, ignored));
    if (exists) {
        const std::string now = read_case_file(file.string());
        if (is_new || content_mark(now) != mark) return {{"changed", true}, {"text", now}, {"mark", content_mark(now)}};
    }
    write_atomically(file, yaml);
    open_later(file);
    return {{"mark", content_mark(yaml)}, {"name", file.filename().string()}};
}

}  // namespace strake
