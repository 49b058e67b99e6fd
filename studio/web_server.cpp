#include "studio/web_server.hpp"

#include "core/error.hpp"

#include <httplib.h>

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
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

/// A connection of which the head of a request is there already: the library would read a line without end.
class BoundedStream : public httplib::Stream {
public:
    /// @param rest behind `head`: reads at most so many bytes; 0 or less: the end.
    BoundedStream(std::string head, std::function<ssize_t(char*, std::size_t)> rest,
                  std::function<ssize_t(const char*, std::size_t)> put, std::size_t max_bytes)
        : head_(std::move(head)), rest_(std::move(rest)), put_(std::move(put)), left_(max_bytes) {}
    bool is_readable() const override { return true; }
    bool is_writable() const override { return true; }
    ssize_t read(char* to, std::size_t size) override {
        size = std::min(size, left_);
        if (size == 0) return 0;
        if (at_ < head_.size()) {
            size = std::min(size, head_.size() - at_);
            std::memcpy(to, head_.data() + at_, size);
            at_ += size;
        } else if (const ssize_t got = rest_(to, size); got > 0) {
            size = static_cast<std::size_t>(got);
        } else {
            return got;
        }
        left_ -= size;
        return static_cast<ssize_t>(size);
    }
    ssize_t write(const char* from, std::size_t size) override { return put_(from, size); }
    void get_remote_ip_and_port(std::string& ip, int& port) const override { ip = "127.0.0.1", port = 0; }
    void get_local_ip_and_port(std::string& ip, int& port) const override { ip = "127.0.0.1", port = 0; }
    socket_t socket() const override { return INVALID_SOCKET; }

private:
    std::string head_;
    std::function<ssize_t(char*, std::size_t)> rest_;
    std::function<ssize_t(const char*, std::size_t)> put_;
    std::size_t at_ = 0, left_;
};

using Clock = std::chrono::steady_clock;

bool wait_for(int socket, short event, Clock::time_point end) {
    for (;;) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
        if (left <= 0) return false;
        pollfd one{socket, event, 0};
        const int ready = ::poll(&one, 1, static_cast<int>(left));
        if (ready > 0) return true;
        if (ready == 0 || errno != EINTR) return false;
    }
}

ssize_t receive(int socket, char* to, std::size_t size, Clock::time_point end) {
    if (!wait_for(socket, POLLIN, end)) return -1;
    return ::recv(socket, to, size, 0);
}

ssize_t send_all(int socket, const char* from, std::size_t size) {
    constexpr auto patience = std::chrono::seconds(10);
    std::size_t sent = 0;
    while (sent < size) {
        if (!wait_for(socket, POLLOUT, Clock::now() + patience)) return -1;
        const ssize_t more = ::send(socket, from + sent, size - sent, MSG_NOSIGNAL);
        if (more <= 0) return -1;
        sent += static_cast<std::size_t>(more);
    }
    return static_cast<ssize_t>(size);
}

/// The request line and headers, and what of the body came along; empty: they do not end within `max_head` bytes or in
/// time.
std::string head_from(const std::function<ssize_t(char*, std::size_t)>& read, std::size_t max_head) {
    std::string head;
    std::array<char, 4096> piece{};
    while (head.size() < max_head) {
        const ssize_t got = read(piece.data(), std::min(piece.size(), max_head - head.size()));
        if (got <= 0) return "";
        const std::size_t from = head.size() < 3 ? 0 : head.size() - 3;
        head.append(piece.data(), static_cast<std::size_t>(got));
        if (head.find("\r\n\r\n", from) != std::string::npos) return head;
    }
    return "";
}

constexpr const char* too_long =
    "HTTP/1.1 431 Request Header Fields Too Large\r\nConnection: close\r\nContent-Length: 0\r\n\r\n";

/// Reads the head of each request itself, up to a limit of bytes and of time.
class BoundedServer : public httplib::Server {
public:
    std::size_t max_head = 16384, max_body = 0;

    void answer_bytes(const std::function<ssize_t(char*, std::size_t)>& read,
                      const std::function<ssize_t(const char*, std::size_t)>& write) {
        std::string head = head_from(read, max_head);
        if (head.empty()) {
            write(too_long, std::strlen(too_long));
            return;
        }
        BoundedStream stream(std::move(head), read, write, max_head + max_body + 1);
        bool is_closed = false;
        process_request(stream, true, is_closed, nullptr);
    }

private:
    bool process_and_close_socket(socket_t socket) override {
        const auto end = Clock::now() + std::chrono::seconds(10);  // of the head and the body together
        answer_bytes([&](char* to, std::size_t size) { return receive(socket, to, size, end); },
                     [&](const char* from, std::size_t size) { return send_all(socket, from, size); });
        // What the other side still sends is thrown away for a moment: closing at once would throw away the answer.
        ::shutdown(socket, SHUT_WR);
        const auto enough = Clock::now() + std::chrono::milliseconds(200);
        std::array<char, 4096> rest{};
        for (std::size_t left = 1 << 20; left > 0;) {
            const ssize_t got = receive(socket, rest.data(), std::min(rest.size(), left), enough);
            if (got <= 0) break;
            left -= static_cast<std::size_t>(got);
        }
        ::close(socket);
        return true;
    }
};

}  // namespace

struct WebServer::Impl {
    BoundedServer server;
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

WebServer::WebServer(int port, WebHandler handler, const std::string& token) : impl_(std::make_unique<Impl>()) {
    Impl& in = *impl_;
    in.handler = std::move(handler);
    in.gate.token = token.empty() ? random_token() : token;
    // The library's own default lets a second studio bind the same port, and the system spreads requests over both.
    in.server.set_socket_options([](int socket) {
        const int yes = 1;
        ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    // One request a connection: of a refused body, which is not read, no second request is made.
    in.server.set_keep_alive_max_count(1);
    in.server.set_payload_max_length(in.gate.max_body);
    in.server.max_body = in.gate.max_body;
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

std::string WebServer::answer_bytes(const std::string& request) {
    std::string answer;
    std::size_t at = 0;
    impl_->server.answer_bytes(
        [&](char* to, std::size_t size) {
            size = std::min(size, request.size() - at);
            std::memcpy(to, request.data() + at, size);
            at += size;
            return static_cast<ssize_t>(size);
        },
        [&](const char* from, std::size_t size) {
            answer.append(from, size);
            return static_cast<ssize_t>(size);
        });
    return answer;
}

void WebServer::start() {
    impl_->thread = std::thread([this] { impl_->server.listen_after_bind(); });
    while (!impl_->server.is_running()) std::this_thread::yield();
}

}  // namespace strake
