#include "studio/studio.hpp"

#include "core/error.hpp"
#include "core/text/hash.hpp"
#include "studio/case_form.hpp"
#include "studio/kept_address.hpp"
#include "studio/studio_impl.hpp"
#include "studio/studio_page.hpp"
#include "viewer/embedded_page.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace strake {

namespace fs = std::filesystem;

std::string text_in(const nlohmann::json& asked, const char* key) {
    if (!asked.contains(key) || !asked[key].is_string()) throw InvalidInput(text("'", key, "' must be a text"));
    return asked[key].get<std::string>();
}

std::string content_mark(const std::string& bytes) { return hash_digits(fnv1a(bytes)); }

Studio::Impl::Impl(const StudioOptions& wishes) : options(wishes) {
    if (options.needs_page && !has_studio_page()) throw OutputError(page_missing("the studio's page"));
    const fs::path target = options.target.empty() ? fs::path(".") : options.target;
    std::error_code error;
    const fs::path real = fs::canonical(target, error);
    if (error) throw InputError(text("studio: ", target.string(), ": ", error.message()));
    folder = fs::is_directory(real) ? real : real.parent_path();
    folder_lock = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    is_second = folder_lock >= 0 && ::flock(folder_lock, LOCK_EX | LOCK_NB) != 0;
    listen();
    if (!fs::is_directory(real) || fs::exists(real / "journal.sqlite", error))
        open_later(real);
    else if (fs::exists(real / "case.yaml", error))
        open_later(real / "case.yaml");
    reader = std::thread([this] { read_targets(); });
    server->start();
}

/// At the address of the last studio of this folder, if that is free: a page that is still open goes on.
void Studio::Impl::listen() {
    const KeptAddress kept = is_second || options.new_address ? KeptAddress{} : kept_address(folder);
    const auto at = [&](int port) {
        server = std::make_unique<WebServer>(
            port, [this](const WebRequest& request) { return answer(request); }, kept.token);
    };
    try {
        at(options.port == 0 ? kept.port : options.port);
    } catch (const OutputError&) {
        if (options.port != 0 || kept.port == 0) throw;
        at(0);
    }
    if (!is_second) keep_address(folder, {server->gate().token, server->gate().port});
}

bool Studio::Impl::leave() {
    if (server && !is_second) keep_address(folder, {server->gate().token, server->gate().port});
    server.reset();
    if (task) task->interrupt();
    const std::lock_guard lock(busy);
    ends = true;
    to_open.clear();
    return is_opening;
}

Studio::Impl::~Impl() {
    leave();
    wanted.notify_all();
    if (reader.joinable()) reader.join();
    if (folder_lock >= 0) ::close(folder_lock);
}

namespace {

/// File names are bytes: what is no UTF-8 in them is replaced.
WebAnswer json_answer(const nlohmann::ordered_json& value, int status = 200) {
    using Json = nlohmann::ordered_json;
    return {status, "application/json", value.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

}  // namespace

WebAnswer Studio::Impl::answer(const WebRequest& request) {
    if (request.body.empty()) return get(request);
    try {
        const Asked asked = Asked::parse(request.body);
        if (!asked.is_object()) throw InvalidInput("the body must be an object");
        return json_answer(post(asked));
    } catch (const Asked::exception& error) {
        return json_answer({{"error", error.what()}}, 400);
    } catch (const std::exception& error) {
        return json_answer({{"error", error.what()}}, 409);
    }
}

WebAnswer Studio::Impl::get(const WebRequest& request) {
    if (request.path == "/") return {200, "text/html; charset=utf-8", std::string(studio_html())};
    if (request.path == "/studio.js") return {200, "text/javascript; charset=utf-8", std::string(studio_script())};
    if (request.path == "/studio.css") return {200, "text/css; charset=utf-8", std::string(studio_style())};
    if (request.path == "/api/state") return json_answer(state(request));
    if (request.path == "/api/files") return json_answer(files());
    if (request.path == "/api/surface") {
        const auto shown = need_subject();
        return {200, "application/octet-stream", shown->payload};
    }
    if (request.path == "/api/case") {
        const std::lock_guard lock(busy);
        return json_answer(
            {{"name", case_file.filename().string()}, {"text", case_text}, {"mark", content_mark(case_text)}});
    }
    if (request.path == "/api/best") return best_shape();
    if (request.path == "/api/keys") return json_answer(case_keys());
    if (request.path == "/api/convergence") return json_answer(convergence(request));
    if (request.path == "/api/designs") return json_answer(designs());
    if (request.path == "/api/design") return design(request);
    if (request.path == "/api/felt_state") return json_answer(felt_state());
    for (const char* what : {"shape", "slope", "envelope", "mode"})
        if (request.path == text("/api/felt/", what)) return felt(what, request);
    if (request.path == "/report") return report();
    return {404, "text/plain", "not found\n"};
}

Studio::Impl::Json Studio::Impl::post(const Asked& asked) {
    const std::string what = text_in(asked, "do");
    if (what == "open") {
        open_later(inside(text_in(asked, "name")));
        return {{"ok", true}};
    }
    if (what == "check") return check(asked);
    if (what == "choose") return choose(asked);
    if (what == "region") return put_region(asked);
    if (what == "form") return form(asked);
    if (what == "set") return set_values(asked);
    if (what == "attach") return attach(asked);
    if (what == "feel") return feel(asked);
    need_write();
    if (what == "save") return save(asked);
    if (what == "propose") return propose(asked);
    if (what == "full_check") return full_check(asked);
    if (what == "run") return start_run(asked);
    if (what == "stop") return stop_run();
    if (what == "resume") return resume_run(asked);
    throw InvalidInput(text("'", what.substr(0, 40), "' is nothing that the studio does"));
}

Studio::Studio(const StudioOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Studio::~Studio() = default;
bool Studio::leave() { return impl_->leave(); }
std::string Studio::url() const { return impl_->server->url(); }
std::string Studio::answer_bytes(const std::string& request) { return impl_->server->answer_bytes(request); }
int Studio::port() const { return impl_->server->gate().port; }

std::string Studio::notice() const {
    if (!impl_->is_second) return "";
    return text("another studio is open on ", impl_->folder.string(),
                "; both may be used, and neither overwrites what the other has saved without a question");
}

void Studio::run(const fs::path& case_file, const fs::path& out, const std::vector<std::string>& settings) {
    const std::lock_guard lock(impl_->busy);
    impl_->begin_run(case_file, out, settings);
}

std::optional<int> Studio::run_status() const {
    const std::lock_guard lock(impl_->busy);
    return impl_->run_child ? impl_->run_child->ended() : std::nullopt;
}

std::string Studio::run_messages() const {
    const std::lock_guard lock(impl_->busy);
    return impl_->run_child ? impl_->run_child->messages() : "";
}

void Studio::interrupt_run() {
    const std::lock_guard lock(impl_->busy);
    if (impl_->run_child && !impl_->run_child->ended()) impl_->run_child->interrupt();
}

std::string Studio::continuing() const {
    const std::lock_guard lock(impl_->busy);
    if (!impl_->run_child || impl_->run_child->ended()) return "";
    return text("the run in ", impl_->run->folder().string(), " goes on; strake status shows it");
}

}  // namespace strake
