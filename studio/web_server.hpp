#pragma once
#include "studio/request_gate.hpp"

#include <functional>
#include <map>
#include <memory>

/// The studio's HTTP server, on the loopback address only (cpp-httplib, seen by one file).
namespace strake {

struct WebRequest {
    std::string path;  ///< behind the token
    std::map<std::string, std::string> query;
    std::string body;  ///< of POST, whose only path is "/api"; empty: GET
};
struct WebAnswer {
    int status = 200;
    std::string type = "application/json", body = {};
    bool is_report = false;  ///< a page of its own: with inline scripts, in a sandbox that reaches nothing of ours
};
/// Called by several threads at a time. What it throws becomes an answer with status 500.
using WebHandler = std::function<WebAnswer(const WebRequest&)>;

class WebServer {
public:
    /// Binds the port (0: any free one). @param token of an earlier start; empty: a new one.
    /// @throws OutputError: in use, or not allowed.
    WebServer(int port, WebHandler handler, const std::string& token = "");
    ~WebServer();  ///< ends open connections
    WebServer(const WebServer&) = delete;
    WebServer& operator=(const WebServer&) = delete;

    const Gate& gate() const;
    std::string url() const;  ///< "http://127.0.0.1:4711/TOKEN/"
    void start();             ///< answers from now on, by threads of its own
    /// The answer to the bytes of a request as they come from a socket: to be tried without one.
    std::string answer_bytes(const std::string& request);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace strake
