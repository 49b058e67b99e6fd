#include "studio/web_server.hpp"

#include "core/error.hpp"

#include <httplib.h>

#include <sys/socket.h>
#include <thread>

namespace strake {
namespace {

constexpr const char* policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data: blob:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// A report has its scripts inside. Without allow-same-origin it cannot ask the studio for anything.
constexpr const char* report_policy =
    "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; frame-ancestors 'none'";

std::optional<std::string> header_of(const httplib::Request& request, const char* name) {
    if (!request.has_header(name)) return {};
    return request.get_header_value(name);
}

RequestHead head_of(const httplib::Request& request) {
    RequestHead head;
    head.method = request.method;
    head.path = request.path;
    for (std::size_t k = 0; k < request.get_header_value_count("Host"); ++k)
        head.host.push_back(request.get_header_value("Host", k));
    head.origin = header_of(request, "Origin");
    head.fetch_site = header_of(request, "Sec-Fetch-Site");
    head.content_type = request.get_header_value("Content-Type");
    if (request.get_header_value_count("Content-Length") < 2)
        head.content_length = header_of(request, "Content-Length");
    head.is_chunked = request.has_header("Transfer-Encoding");
    head.is_encoded = request.has_header("Content-Encoding");
    return head;
}

}  // namespace

struct WebServer::Impl {
    httplib::Server server;
    Gate gate;
    WebHandler handler;
    std::thread thread;

    void put(const WebAnswer& answer, httplib::Response& response) const {
        response.status = answer.status;
        response.set_content(answer.body, answer.type);
        response.set_header("Content-Security-Policy", answer.is_report ? report_policy : policy);
        response.set_header("X-Content-Type-Options", "nosniff");
        response.set_header("Referrer-Policy", "no-referrer");
        response.set_header("Cross-Origin-Resource-Policy", "same-origin");
        response.set_header("Cross-Origin-Opener-Policy", "same-origin");
        response.set_header("Cache-Control", "no-store");
    }
    void answer(const httplib::Request& request, httplib::Response& response) const {
        WebRequest asked{inner_path(gate, request.path), {}, request.body};
        for (const auto& [name, value] : request.params) asked.query[name] = value;
        try {
            put(handler(asked), response);
        } catch (const std::exception& error) {
            put({500, "text/plain", error.what()}, response);
        }
    }
};

WebServer::WebServer(int port, WebHandler handler) : impl_(std::make_unique<Impl>()) {
    Impl& in = *impl_;
    in.handler = std::move(handler);
    in.gate.token = random_token();
    // The library's own default lets a second studio bind the same port, and the system spreads requests over both.
    in.server.set_socket_options([](int socket) {
        const int yes = 1;
        ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    // One request a connection: of a refused body, which is not read, no second request is made.
    in.server.set_keep_alive_max_count(1);
    in.server.set_payload_max_length(in.gate.max_body);
    in.server.set_read_timeout(10);
    in.gate.port = port;
    if (port == 0)
        in.gate.port = in.server.bind_to_any_port("127.0.0.1");
    else if (!in.server.bind_to_port("127.0.0.1", port))
        in.gate.port = -1;
    if (in.gate.port <= 0)
        throw OutputError(text("studio: port ", port,
                               " cannot be used: another program has it, or it is reserved; "
                               "choose another one with --port, or leave it out"));
    // Before bodies are read. GET needs none and is answered here, without a pattern of paths.
    in.server.set_pre_routing_handler([&in](const httplib::Request& request, httplib::Response& response) {
        if (const auto refused = refusal(in.gate, head_of(request)))
            in.put({refused->status, "text/plain", refused->words + "\n"}, response);
        else if (request.method == "GET")
            in.answer(request, response);
        else
            return httplib::Server::HandlerResponse::Unhandled;
        return httplib::Server::HandlerResponse::Handled;
    });
    in.server.Post("/" + in.gate.token + "/api", [&in](const httplib::Request& request, httplib::Response& response) {
        in.answer(request, response);
    });
}

WebServer::~WebServer() {
    impl_->server.stop();
    if (impl_->thread.joinable()) impl_->thread.join();
}

const Gate& WebServer::gate() const { return impl_->gate; }

std::string WebServer::url() const { return text("http://127.0.0.1:", gate().port, "/", gate().token, "/"); }

void WebServer::start() {
    impl_->thread = std::thread([this] { impl_->server.listen_after_bind(); });
    while (!impl_->server.is_running()) std::this_thread::yield();
}

}  // namespace strake
