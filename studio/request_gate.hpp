#pragma once
#include <optional>
#include <string>
#include <vector>

/// Which requests the studio answers at all. Whoever reaches the port (another user of the machine, a page from
/// elsewhere in the user's browser) must get nothing.
namespace strake {

struct Gate {
    std::string token;               ///< first part of every path
    int port = 0;                    ///< where the server listens on the loopback address
    std::size_t max_body = 4 << 20;  ///< bytes
};

/// What is known of a request before its body is read.
struct RequestHead {
    std::string method, path;               ///< the path decoded, without the query
    std::vector<std::string> host;          ///< of each header of that name
    std::optional<std::string> origin;      ///< of the page that asks; programs send none
    std::optional<std::string> fetch_site;  ///< Sec-Fetch-Site
    std::string content_type;
    std::optional<std::string> content_length;
    bool is_chunked = false, is_encoded = false;  ///< a body of unknown length; compressed
};

struct Refusal {
    int status;         ///< of HTTP
    std::string words;  ///< for the answer; tells nothing about the token
};

/// Nothing: the request may be answered. Refused are, in this order: a Host other than 127.0.0.1 or localhost with our
/// port (403: a name of elsewhere that resolves to us), an Origin or Sec-Fetch-Site of another page (403), a path
/// without the token (404), methods other than GET and POST (405), and of POST a body that is no JSON (415), has no
/// length or an unreadable one, is chunked or compressed (411), or is longer than `max_body` (413).
std::optional<Refusal> refusal(const Gate& gate, const RequestHead& head);

/// The path behind the token, "/api/state". @pre not refused
std::string inner_path(const Gate& gate, const std::string& path);

/// 32 hexadecimal digits from the system's random numbers. @throws OutputError if it has none.
std::string random_token();

}  // namespace strake
