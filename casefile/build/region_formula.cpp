#include "casefile/build/region_formula.hpp"

#include "casefile/yaml/diagnostics.hpp"
#include "core/error.hpp"

namespace strake {
namespace {

constexpr int max_depth = 100;  ///< of parentheses

struct Token {
    enum class Kind { name, sign, open, close } kind;
    std::string text;
};

std::vector<Token> tokens_of(const std::string& formula) {
    std::vector<Token> tokens;
    const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
    for (std::size_t i = 0; i < formula.size();) {
        const char c = formula[i];
        if (is_blank(c)) {
            ++i;
        } else if (c == '(' || c == ')') {
            tokens.push_back({c == '(' ? Token::Kind::open : Token::Kind::close, std::string(1, c)});
            ++i;
        } else if (c == '"') {
            const std::size_t end = formula.find('"', i + 1);
            if (end == std::string::npos)
                throw InvalidInput(text("'", printable(formula), "': a double quote is not closed"));
            tokens.push_back({Token::Kind::name, formula.substr(i + 1, end - i - 1)});
            i = end + 1;
        } else {
            std::size_t end = i;
            while (end < formula.size() && !is_blank(formula[end]) && formula[end] != '(' && formula[end] != ')') ++end;
            const std::string word = formula.substr(i, end - i);
            const bool is_sign = word == "+" || word == "-" || word == "&";
            tokens.push_back({is_sign ? Token::Kind::sign : Token::Kind::name, word});
            i = end;
        }
    }
    return tokens;
}

/// sum := product (+|- product)*; product := item (& item)*; item := name | ( sum )
class Parser {
public:
    Parser(const std::string& formula, const std::function<TriangleMarks(const std::string&)>& named)
        : formula_(formula), named_(named), tokens_(tokens_of(formula)) {}

    TriangleMarks all() {
        TriangleMarks marks = sum(0);
        if (at_ < tokens_.size())
            fail(text("a sign (+, - or &) is missing before '", printable(tokens_[at_].text), "'"));
        return marks;
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InvalidInput(text("'", printable(formula_), "': ", what));
    }
    bool next_is(const char* sign) const {
        return at_ < tokens_.size() && tokens_[at_].kind == Token::Kind::sign && tokens_[at_].text == sign;
    }

    TriangleMarks sum(int depth) {
        TriangleMarks left = product(depth);
        while (next_is("+") || next_is("-")) {
            const bool adds = tokens_[at_++].text == "+";
            const TriangleMarks right = product(depth);
            for (std::size_t t = 0; t < left.size(); ++t) left[t] = adds ? left[t] || right[t] : left[t] && !right[t];
        }
        return left;
    }

    TriangleMarks product(int depth) {
        TriangleMarks left = item(depth);
        while (next_is("&")) {
            ++at_;
            const TriangleMarks right = item(depth);
            for (std::size_t t = 0; t < left.size(); ++t) left[t] = left[t] && right[t];
        }
        return left;
    }

    TriangleMarks item(int depth) {
        if (at_ == tokens_.size()) fail(tokens_.empty() ? "a name is missing" : "a name is missing at the end");
        const Token& token = tokens_[at_++];
        if (token.kind == Token::Kind::name) return named_(token.text);
        if (token.kind != Token::Kind::open) fail(text("a name is missing before '", token.text, "'"));
        if (depth == max_depth) fail(text("more than ", max_depth, " parentheses within each other"));
        TriangleMarks inside = sum(depth + 1);
        if (at_ == tokens_.size() || tokens_[at_].kind != Token::Kind::close) fail("a parenthesis is not closed");
        ++at_;
        return inside;
    }

    const std::string& formula_;
    const std::function<TriangleMarks(const std::string&)>& named_;
    std::vector<Token> tokens_;
    std::size_t at_ = 0;
};

}  // namespace

TriangleMarks evaluate_formula(const std::string& formula,
                               const std::function<TriangleMarks(const std::string&)>& named) {
    return Parser(formula, named).all();
}

std::vector<std::string> names_in_formula(const std::string& formula) {
    std::vector<std::string> names;
    evaluate_formula(formula, [&](const std::string& name) {
        names.push_back(name);
        return TriangleMarks{};
    });
    return names;
}

}  // namespace strake
