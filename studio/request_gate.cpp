#include "studio/request_gate.hpp"

#include "core/error.hpp"

#include <sys/random.h>
#include <algorithm>
#include <array>
#include <charconv>

namespace strake {
namespace {

constexpr std::size_t max_path = 300;

bool is_ours(const Gate& gate, const std::string& host) {
    return host == text("127.0.0.1:", gate.port) || host == text("localhost:", gate.port);
}

/// Takes as long for a wrong token as for the right one.
bool same(const std::string& a, const std::string& b) {
    if (a.size() != b.size()) return false;
    unsigned char difference = 0;
    for (std::size_t k = 0; k < a.size(); ++k) difference |= static_cast<unsigned char>(a[k] ^ b[k]);
    return difference == 0;
}

bool has_token(const Gate& gate, const std::string& path) {
    return !gate.token.empty() && path.size() <= max_path && path.starts_with('/') &&
           same(path.substr(1, path.find('/', 1) - 1), gate.token) && path.size() > gate.token.size() + 1;
}

std::optional<Refusal> refused_body(const Gate& gate, const RequestHead& head) {
    if (!head.content_type.starts_with("application/json")) return Refusal{415, "the body must be application/json"};
    if (head.is_chunked || head.is_encoded || !head.content_length)
        return Refusal{411, "the body must come with its length, uncompressed and in one piece"};
    std::size_t length = 0;
    const std::string& words = *head.content_length;
    const auto [end, error] = std::from_chars(words.data(), words.data() + words.size(), length);
    if (error == std::errc::result_out_of_range || (error == std::errc{} && length > gate.max_body))
        return Refusal{413, text("the body must not be longer than ", gate.max_body, " bytes")};
    if (error != std::errc{} || end != words.data() + words.size()) return Refusal{411, "Content-Length is no number"};
    return {};
}

}  // namespace

std::optional<Refusal> refusal(const Gate& gate, const RequestHead& head) {
    if (head.host.size() != 1 || !is_ours(gate, head.host.front()))
        return Refusal{403, text("only http://127.0.0.1:", gate.port, " and http://localhost:", gate.port,
                                 " are answered: forward the same port")};
    if (head.origin && (!head.origin->starts_with("http://") || !is_ours(gate, head.origin->substr(7))))
        return Refusal{403, "requests of other pages are refused"};
    if (head.fetch_site && *head.fetch_site != "same-origin" && *head.fetch_site != "none")
        return Refusal{403, "requests of other pages are refused"};
    if (!has_token(gate, head.path))
        return Refusal{404, "not found: take the whole address that strake studio printed"};
    if (head.method != "GET" && head.method != "POST") return Refusal{405, "only GET and POST"};
    if (head.method == "POST") return refused_body(gate, head);
    if (head.is_chunked || head.content_length.value_or("0") != "0") return Refusal{413, "GET has no body"};
    return {};
}

std::string inner_path(const Gate& gate, const std::string& path) { return path.substr(gate.token.size() + 1); }

std::string random_token() {
    std::array<unsigned char, 16> bytes{};
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        throw OutputError("studio: the system gives no random numbers for the address");
    std::string token;
    for (const unsigned char byte : bytes) {
        token += "0123456789abcdef"[byte >> 4];
        token += "0123456789abcdef"[byte & 15];
    }
    return token;
}

}  // namespace strake
