#include "participants/files/stl_file.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <string_view>

#include "coupler/base/error.hpp"
#include "participants/files/lines.hpp"

namespace files {
namespace {

//! Whether three corners lie on a line: the height over the longest side is below 1e-10 of that side, so that rounding
//! would turn the normal by more than 1e-6.
bool has_no_area(Triangle const& t)
{
    auto const edge = [&](std::size_t k) {
        Point const &from = t[k], &to = t[(k + 1) % 3];
        return Point{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    };
    double longest = 0.0;  // square of it
    for (std::size_t k = 0; k < 3; ++k) {
        Point const e = edge(k);
        longest = std::max(longest, e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
    }
    Point const a = edge(0), b = edge(1);
    double const across = std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
    return !(across > 1e-10 * longest);
}

constexpr char const* no_area = "has corners on one line (must have an area). Remove it.";

bool is_word(std::string_view word, std::string_view wanted)
{
    return std::ranges::equal(word, wanted, [](unsigned char a, unsigned char b) { return std::tolower(a) == b; });
}

//! A text, line by line.
class StlText
{
 public:
    explicit StlText(Lines lines) : lines_(std::move(lines)) {}

    std::vector<Triangle> triangles()
    {
        std::vector<Triangle> found;
        bool within = false;
        while (next()) {
            if (is_word(word_, "facet")) {
                found.push_back(facet());
            } else if (is_word(word_, "solid")) {
                within = true;
            } else if (is_word(word_, "endsolid")) {
                within = false;
            } else {
                wanted("facet, endsolid or solid");
            }
        }
        if (within) cut_off("endsolid");
        return found;
    }

 private:
    //! The next line that is not empty: its first word and what follows it.
    bool next()
    {
        while (lines_.next()) {
            rest_ = trimmed(lines_.text());
            word_ = take_word(rest_, ' ');
            if (!word_.empty()) return true;
        }
        return false;
    }
    void need(std::string_view wanted_word)
    {
        if (!next()) cut_off(wanted_word);
        if (!is_word(word_, wanted_word)) wanted(wanted_word);
    }
    Triangle facet()
    {
        std::int64_t const begin = lines_.number();
        Triangle t;
        need("outer");
        for (Point& corner : t) {
            need("vertex");
            corner = vertex();
        }
        need("endloop");
        need("endfacet");
        if (has_no_area(t)) lines_.fail_at(begin, std::string("the facet ") + no_area);
        return t;
    }
    Point vertex()
    {
        std::string const seen(trimmed(rest_));
        Point corner;
        for (double& coordinate : corner) {
            auto const number = number_in(take_word(rest_, ' '));
            if (!number || !std::isfinite(*number)) lines_.fail("vertex " + seen + " (needed: three finite numbers).");
            coordinate = *number;
        }
        if (!trimmed(rest_).empty()) lines_.fail("vertex " + seen + " (needed: three numbers and no more).");
        return corner;
    }
    [[noreturn]] void wanted(std::string_view what) const
    {
        constexpr std::size_t shown = 32;
        std::string const seen(word_.substr(0, shown));
        lines_.fail("begins with \"" + seen + "\" (needed: " + std::string(what) + ").");
    }
    [[noreturn]] void cut_off(std::string_view what) const
    {
        lines_.fail("is the last line (needed: " + std::string(what) + " after it). Is the file complete?");
    }

    Lines lines_;
    std::string_view word_, rest_;
};

//! Numbers of a binary file: little-endian, whatever this machine is.
std::uint32_t integer_at(std::span<char const> bytes, std::size_t at)
{
    std::uint32_t value = 0;
    for (std::size_t k = 4; k-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
    return value;
}
double number_at(std::span<char const> bytes, std::size_t at)
{
    return std::bit_cast<float>(integer_at(bytes, at));
}

//! 80 bytes of anything, the number of facets, and for each 50 bytes: normal, three corners, two bytes more.
std::vector<Triangle> read_binary(std::string const& name, std::span<char const> bytes)
{
    constexpr std::size_t header = 80, before = header + 4, facet_size = 50, of_corners = 12;
    auto const fail = [&](std::string const& text) { throw sluice::Error(name + ": " + text); };
    if (bytes.size() < before)
        fail("has " + std::to_string(bytes.size()) +
             " bytes (needed: an STL, text from `solid` on, or binary with at least 84 bytes). Is the file complete?");
    std::size_t const count = integer_at(bytes, header), needed = before + count * facet_size;
    if (bytes.size() != needed)
        fail("has " + std::to_string(bytes.size()) + " bytes (a binary STL of " + std::to_string(count) +
             " facets, as it says, needs " + std::to_string(needed) + "; a text begins with `solid`). Is it complete?");
    std::vector<Triangle> found(count);
    for (std::size_t f = 0; f < count; ++f) {
        auto const refuse = [&](std::string const& text) { fail("facet " + std::to_string(f + 1) + ": " + text); };
        std::size_t at = before + f * facet_size + of_corners;
        for (Point& corner : found[f])
            for (double& coordinate : corner) {
                double const number = number_at(bytes, at);
                if (!std::isfinite(number)) refuse("has a corner that is no number (needed: three finite numbers).");
                coordinate = number;
                at += 4;
            }
        if (has_no_area(found[f])) refuse(no_area);
    }
    return found;
}

bool is_text(std::span<char const> bytes)
{
    auto const head = std::string_view(bytes.data(), bytes.size()).substr(0, 1024);
    auto const from = head.find_first_not_of(" \t\r\n");
    return from != std::string_view::npos && is_word(head.substr(from, 5), "solid") &&
           head.find('\0') == std::string_view::npos;
}

}  // namespace

std::vector<Triangle> read_stl(std::filesystem::path const& file)
{
    Lines lines(file);
    std::ifstream in(file, std::ios::binary);
    std::vector<char> const bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    auto found = is_text(bytes) ? StlText(std::move(lines)).triangles() : read_binary(file.string(), bytes);
    sluice::require(!found.empty(),
                    [&] { return sluice::Error(file.string() + ": holds no facets (needed: at least one)."); });
    return found;
}

}  // namespace files
