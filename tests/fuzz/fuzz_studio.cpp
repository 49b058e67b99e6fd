#include "core/text/file.hpp"
#include "studio/studio.hpp"
#include "tests/casefile/folder.hpp"

#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

/// Whatever is sent to the studio, each request gets one answer of HTTP, nothing outside of the folder is read or
/// changed, and a read-only studio changes nothing at all. No request here starts a process.
namespace {

using namespace strake;
namespace fs = std::filesystem;

void require(bool kept, const char* promise) {
    if (kept) return;
    std::fprintf(stderr, "broken promise: %s\n", promise);
    std::abort();
}

constexpr const char* secret = "surface: TOP-SECRET\n";
constexpr const char* case_text =
    "surface: {file: body.obj}\nregions: {a: {triangles: t.txt}}\nfixed: [a]\nobjective: {maximize: area}\n"
    "parameters: {levels: auto, variables: [normal], max_displacement: 5%}\n";

/// A folder, what lies around it, and a studio on it.
class Ground {
public:
    explicit Ground(bool read_only) {
        fs::create_directories(mine());
        around_.write("secret.yaml", secret);
        write_atomically(mine() / "body.obj", tetrahedron_obj);
        write_atomically(mine() / "t.txt", "0\n");
        write_atomically(mine() / "case.yaml", case_text);
        fs::create_symlink("../secret.yaml", mine() / "link.yaml");
        StudioOptions options;
        options.target = mine() / "case.yaml";
        options.read_only = read_only;
        options.new_address = true;
        options.needs_page = false;
        studio_ = std::make_unique<Studio>(options);
        const std::string url = studio_->url(), behind = url.substr(url.find("1:") + 2);
        host_ = "127.0.0.1:" + behind.substr(0, behind.find('/'));
        token_ = behind.substr(behind.find('/') + 1, 32);
        while (get("api/state").find("\"is_opening\":true") != std::string::npos)
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    std::string send(const std::string& request) {
        const std::string answer = studio_->answer_bytes(request);
        require(answer.empty() || answer.starts_with("HTTP/1.1 "), "answers are HTTP");
        // The fuzzer sees what is compared, and sends it; that comes back in messages.
        require(request.find("TOP-SECRET") != std::string::npos || answer.find("TOP-SECRET") == std::string::npos,
                "nothing outside of the folder is read");
        return answer;
    }
    std::string get(const std::string& path) {
        return send("GET /" + token_ + "/" + path + " HTTP/1.1\r\nHost: " + host_ + "\r\n\r\n");
    }
    std::string post(const std::string& body) {
        return send("POST /" + token_ + "/api HTTP/1.1\r\nHost: " + host_ +
                    "\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) +
                    "\r\n\r\n" + body);
    }
    /// $T and $H of a request mean the token and the host.
    std::string filled_in(std::string request) const {
        for (const auto& [sign, words] : {std::pair{"$T", &token_}, std::pair{"$H", &host_}})
            for (std::size_t at = 0; (at = request.find(sign, at)) != std::string::npos; at += words->size())
                request.replace(at, 2, *words);
        return request;
    }
    void check_around() const {
        require(read_bytes(around_.path() / "secret.yaml") == secret, "nothing outside of the folder is changed");
        int count = 0;
        for (const auto& entry : fs::directory_iterator(around_.path())) count += entry.exists() ? 1 : 0;
        require(count == 2, "nothing is written outside of the folder");
    }
    void check_unchanged() const {
        require(read_bytes(mine() / "case.yaml") == case_text, "a read-only studio changes no case");
        int count = 0;
        for (const auto& entry : fs::directory_iterator(mine())) count += entry.exists() ? 1 : 0;
        require(count == 4, "a read-only studio writes nothing");
    }
    /// What was written is removed: the folder is to stay small.
    void tidy() const {
        for (const auto& entry : fs::directory_iterator(mine()))
            if (const std::string name = entry.path().filename().string();
                name != "body.obj" && name != "t.txt" && name != "case.yaml" && name != "link.yaml")
                fs::remove_all(entry.path());
        write_atomically(mine() / "case.yaml", case_text);
    }

private:
    fs::path mine() const { return around_.path() / "mine"; }
    Folder around_;
    std::unique_ptr<Studio> studio_;
    std::string host_, token_;
};

/// Pieces of the input between zero bytes.
std::vector<std::string> pieces_of(const std::string& bytes) {
    std::vector<std::string> pieces(1);
    for (const char c : bytes)
        if (c == '\0')
            pieces.emplace_back();
        else
            pieces.back() += c;
    return pieces;
}

/// A request that writes: what it does is ours, its members are the input's.
std::string writing_body(const std::string& bytes) {
    auto pieces = pieces_of(bytes);
    pieces.resize(5);
    nlohmann::json body{{"do", pieces[0].size() % 2 ? "save" : "region"},
                        {"name", pieces[1]},
                        {"text", pieces[2]},
                        {"mark", pieces[3]}};
    body["steps"] = nlohmann::json::parse(pieces[4], nullptr, false);
    if (body["steps"].is_discarded()) body["steps"] = {{{"triangles", {0}}}};
    return body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
    if (size == 0) return 0;
    static Ground looks(true), writes(false);
    static int count = 0;
    const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
    switch (data[0] % 4) {
        case 0:
            looks.send(looks.filled_in(bytes));
            break;
        case 1:
            looks.post(bytes);
            break;
        case 2:
            looks.get(bytes);
            break;
        default:
            writes.post(writing_body(bytes));
            break;
    }
    writes.check_around();
    if (++count % 32 == 0) {
        looks.check_unchanged();
        looks.check_around();
        writes.tidy();
    }
    return 0;
}
