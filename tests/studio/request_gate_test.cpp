#include "studio/request_gate.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

const Gate gate{"0123456789abcdef0123456789abcdef", 4711, 1000};

RequestHead good() {
    RequestHead head;
    head.method = "GET";
    head.path = "/" + gate.token + "/";
    head.host = {"127.0.0.1:4711"};
    return head;
}

RequestHead good_post() {
    RequestHead head = good();
    head.method = "POST";
    head.path += "api";
    head.content_type = "application/json";
    head.content_length = "1000";
    return head;
}

/// Status of the refusal, 0: none.
int status(const RequestHead& head, const Gate& of = gate) {
    const auto refused = refusal(of, head);
    return refused ? refused->status : 0;
}

TEST(RequestGate, LetsTheOwnPageThrough) {
    EXPECT_EQ(status(good()), 0);
    EXPECT_EQ(status(good_post()), 0);
    RequestHead head = good_post();
    head.host = {"localhost:4711"};
    head.origin = "http://localhost:4711";
    head.fetch_site = "same-origin";
    EXPECT_EQ(status(head), 0);
    EXPECT_EQ(inner_path(gate, head.path), "/api");
}

TEST(RequestGate, RefusesOtherHosts) {
    for (const std::string host :
         {"", "evil.example", "evil.example:4711", "127.0.0.1", "127.0.0.1:80", "localhost:47110",
          "127.0.0.1:4711.evil.example", "0.0.0.0:4711", "LOCALHOST:4711"}) {
        RequestHead head = good();
        head.host = {host};
        EXPECT_EQ(status(head), 403) << host;
    }
    RequestHead head = good();
    head.host = {};
    EXPECT_EQ(status(head), 403);
    head.host = {"127.0.0.1:4711", "127.0.0.1:4711"};
    EXPECT_EQ(status(head), 403);
}

TEST(RequestGate, RefusesOtherPages) {
    for (const std::string origin : {"null", "", "http://evil.example", "https://127.0.0.1:4711",
                                     "http://127.0.0.1:4712", "http://127.0.0.1:4711.evil.example", "127.0.0.1:4711"}) {
        RequestHead head = good_post();
        head.origin = origin;
        EXPECT_EQ(status(head), 403) << origin;
    }
    for (const std::string site : {"cross-site", "same-site", ""}) {
        RequestHead head = good();
        head.fetch_site = site;
        EXPECT_EQ(status(head), 403) << site;
    }
}

TEST(RequestGate, RefusesPathsWithoutTheToken) {
    const std::string& token = gate.token;
    for (const std::string& path :
         {std::string("/"), std::string(""), "/" + token, "/" + token.substr(1) + "/", "/x" + token + "/",
          "/" + token + "0/", "//" + token + "/", std::string("/0123456789abcdef0123456789abcdee/"),
          "/" + token + "/" + std::string(300, 'a')}) {
        RequestHead head = good();
        head.path = path;
        EXPECT_EQ(status(head), 404) << path;
    }
    RequestHead head = good();
    head.path = "//";
    EXPECT_EQ(status(head, Gate{"", 4711, 1000}), 404) << "a gate without a token lets nobody through";
}

TEST(RequestGate, RefusesOtherMethodsAndBodies) {
    RequestHead head = good();
    for (const std::string method : {"PUT", "DELETE", "OPTIONS", "HEAD", "PATCH", "get"}) {
        head.method = method;
        EXPECT_EQ(status(head), 405) << method;
    }
    head = good();
    head.content_length = "1";
    EXPECT_EQ(status(head), 413);
    head = good_post();
    head.content_length = "1001";
    EXPECT_EQ(status(head), 413);
    head.content_length = "99999999999999999999999999";
    EXPECT_EQ(status(head), 413);
    for (const std::string length : {"", "-1", "12x", " 12", "0x10"}) {
        head.content_length = length;
        EXPECT_EQ(status(head), 411) << length;
    }
    head.content_length.reset();
    EXPECT_EQ(status(head), 411);
    head = good_post();
    head.is_chunked = true;
    EXPECT_EQ(status(head), 411);
    head = good_post();
    head.is_encoded = true;
    EXPECT_EQ(status(head), 411);
    for (const std::string type : {"", "text/plain", "application/x-www-form-urlencoded", "multipart/form-data"}) {
        head = good_post();
        head.content_type = type;
        EXPECT_EQ(status(head), 415) << type;
    }
}

TEST(RequestGate, TokensDiffer) {
    const std::string one = random_token(), other = random_token();
    EXPECT_EQ(one.size(), 32u);
    EXPECT_EQ(one.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_NE(one, other);
}

}  // namespace
}  // namespace strake
