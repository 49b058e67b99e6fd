#include "optimize/journal/answer_cache.hpp"

#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/text/file.hpp"
#include "optimize/journal/content_hash.hpp"
#include "optimize/journal/packed_arrays.hpp"

#include <cstring>
#include <stdexcept>

namespace strake {
namespace {

namespace fs = std::filesystem;

constexpr const char* magic = "strake answer 1\n";

void put(std::string& bytes, const std::string& part) {
    const std::uint64_t size = part.size();
    bytes.append(reinterpret_cast<const char*>(&size), sizeof size).append(part);
}

/// The next part, or an exception: the file is cut.
std::string take(const std::string& bytes, std::size_t& at) {
    std::uint64_t size = 0;
    if (bytes.size() - at < sizeof size) throw std::out_of_range("cut");
    std::memcpy(&size, bytes.data() + at, sizeof size);
    at += sizeof size;
    if (bytes.size() - at < size) throw std::out_of_range("cut");
    at += size;
    return bytes.substr(at - size, size);
}

/// All that decides the answer.
std::string question_of(const Quantity& quantity, const QuantityRequest& request) {
    std::string question = text(request.surface_hash, " ", request.surface.num_vertices(), " ",
                                request.surface.num_triangles(), " ", request.want_sensitivities, "\n");
    for (const auto& [name, value] : request.parameters) question += name + "=" + packed({value}) + "\n";
    return question + content_hash(quantity.cache_key) + " " + std::to_string(quantity.cache_key.size());
}

std::string file_bytes(const std::string& question, const QuantityResult& answer) {
    std::string bytes = magic;
    for (const std::string& part :
         {question, packed(answer.values), packed_all(answer.dJ_dv), packed_all(answer.dJ_dp)})
        put(bytes, part);
    return bytes + content_hash(bytes);
}

/// @throws std::exception where the file is not what was written for this question.
QuantityResult answer_in(const std::string& bytes, const std::string& question) {
    constexpr std::size_t digits = 16;
    const std::size_t head = std::strlen(magic);
    if (bytes.size() < head + digits || bytes.compare(0, head, magic) != 0) throw std::out_of_range("cut");
    const std::string body = bytes.substr(0, bytes.size() - digits);
    if (content_hash(body) != bytes.substr(body.size())) throw std::out_of_range("check sum");
    std::size_t at = head;
    if (take(body, at) != question) throw std::out_of_range("another question");
    QuantityResult answer;
    answer.values = unpacked(take(body, at));
    answer.dJ_dv = unpacked_gradients(take(body, at));
    answer.dJ_dp = unpacked_derivatives(take(body, at));
    return answer;
}

}  // namespace

QuantityResult cached_answer(const Quantity& quantity, const QuantityRequest& request) {
    const std::string question = question_of(quantity, request);
    const fs::path file = quantity.cache / (content_hash(question) + ".answer");
    std::vector<std::string> remarks;
    std::error_code ignored;
    if (fs::exists(fs::symlink_status(file, ignored))) try {
            QuantityResult answer = answer_in(read_bytes(file), question);
            answer.remarks.push_back(text(quantity.names[0], " is taken from the cache"));
            return answer;
        } catch (const std::exception&) {
            remarks.push_back(text(file.string(), ": is damaged or of another program, and is not used"));
        }
    QuantityResult answer = quantity.evaluate(request);
    if (!answer.failure && !answer.is_substitute) try {
            fs::create_directories(quantity.cache, ignored);
            write_atomically(file, file_bytes(question, answer));
        } catch (const std::exception& why) {  // the answer itself may have taken hours: the run goes on with it
            remarks.push_back(text("the answer of ", quantity.names[0], " is not kept for other runs: ", why.what()));
        }
    answer.remarks.insert(answer.remarks.begin(), remarks.begin(), remarks.end());
    return answer;
}

}  // namespace strake
