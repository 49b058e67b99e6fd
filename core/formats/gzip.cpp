#include "core/error.hpp"
#include "core/formats/formats.hpp"

#include <zlib.h>
#include <algorithm>
#include <memory>

/// Files compressed by gzip, for example `hull.stl.gz`.
namespace strake::formats {
namespace {

constexpr std::size_t largest_ratio = 1000;  ///< surfaces compress by a factor of ten; more than this is malicious
constexpr std::size_t chunk = std::size_t{1} << 20;

class Inflater {
public:
    Inflater(std::string_view packed, const std::string& name) : name_(name), left_(packed), total_(packed.size()) {
        if (inflateInit2(&stream_, 15 + 16) != Z_OK) throw std::bad_alloc();
    }
    ~Inflater() { inflateEnd(&stream_); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    /// All members in sequence, like gzip.
    std::string all() {
        std::string out;
        while (true) {
            feed();
            const std::size_t known = out.size();
            out.resize(known + chunk);
            stream_.next_out = reinterpret_cast<Bytef*>(out.data() + known);
            stream_.avail_out = static_cast<uInt>(chunk);
            const int state = inflate(&stream_, Z_NO_FLUSH);
            out.resize(known + chunk - stream_.avail_out);
            if (out.size() / largest_ratio > total_)
                fail(text("unpacks to more than ", largest_ratio, " times its size, which no surface does"));
            if (state == Z_STREAM_END && !next_member()) return out;
            if (state == Z_MEM_ERROR) throw std::bad_alloc();
            if (state != Z_OK && state != Z_STREAM_END && state != Z_BUF_ERROR)
                fail(stream_.msg ? stream_.msg : "damaged");
            if (state == Z_BUF_ERROR && stream_.avail_in == 0 && left_.empty()) fail("the packed data end too early");
        }
    }

private:
    void feed() {
        if (stream_.avail_in > 0) return;
        const std::size_t size = std::min(left_.size(), chunk);
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(left_.data()));
        stream_.avail_in = static_cast<uInt>(size);
        left_.remove_prefix(size);
    }
    bool next_member() {
        feed();
        if (stream_.avail_in == 0) return false;
        return inflateReset(&stream_) == Z_OK;
    }
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(text(name_, ": byte ", total_ - left_.size() - stream_.avail_in, ": gzip: ", what));
    }

    const std::string& name_;
    std::string_view left_;
    std::size_t total_;
    z_stream stream_{};
};

}  // namespace

std::string unpacked(std::string_view bytes, const std::string& name) { return Inflater(bytes, name).all(); }

}  // namespace strake::formats
