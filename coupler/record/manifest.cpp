#include "coupler/record/manifest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "coupler/base/error.hpp"

namespace sluice {
namespace {

using Json = nlohmann::ordered_json;

constexpr int format = 1;
constexpr int deepest = 3;  // the list of members holds one object each

bool is_version(std::string_view text)
{
    return !text.empty() && text.size() <= 64 &&
           std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c <= '~'; });
}

//! The first rule that a manifest breaks; empty: none.
std::string broken_rule(Manifest const& m)
{
    if (!is_version(m.version)) return "the version of Sluice is no word";
    if (m.window < 0) return "a window before the first";
    if (m.previous && (*m.previous < 0 || *m.previous >= m.window)) return "a previous window that is not before it";
    if (!std::isfinite(m.tick) || !(m.tick > 0)) return "a tick that is not above 0 s";
    if (m.members.empty()) return "no members";
    if (m.members.size() > Manifest::most_members) return "too many members";
    for (std::size_t i = 0; i < m.members.size(); ++i) {
        if (!is_member(m.members[i].member)) return "a member whose name is none";
        if (i > 0 && m.members[i - 1].member >= m.members[i].member) return "members out of order";
    }
    return {};
}

//! `digest` stands last, alone on its line: what it covers is all before that line.
std::string with_digest(std::string_view covered, std::string_view digest)
{
    return fmt::format("{},\n \"xxh3\": \"{}\"\n}}\n", covered, digest);
}
constexpr std::size_t digest_line = 48;  // characters that with_digest() adds

Digest digest_of_text(std::string_view text)
{
    return digest_of(std::as_bytes(std::span(text)));
}

std::string covered_text(Manifest const& m)
{
    Json members = Json::array();
    for (auto const& part : m.members)
        members.push_back({{"member", part.member}, {"bytes", part.bytes}, {"xxh3", hex(part.digest)}});
    Json const json = {{"format", format},
                       {"sluice", m.version},
                       {"scene", hex(m.scene)},
                       {"window", m.window},
                       {"ticks", m.ticks},
                       {"tick", m.tick},
                       {"previous", m.previous ? Json(*m.previous) : Json()},
                       {"members", members}};
    auto text = json.dump(1);
    text.resize(text.size() - 2);  // "\n}"
    return text;
}

//! Typed access; throws the reason alone.
struct WrongForm
{
    std::string why;
};

Json const& value(Json const& json, char const* key)
{
    if (!json.is_object() || !json.contains(key)) throw WrongForm{fmt::format("{} is missing", key)};
    return json[key];
}

std::string word(Json const& json, char const* key)
{
    auto const& v = value(json, key);
    if (!v.is_string()) throw WrongForm{fmt::format("{} is no text", key)};
    return v.get<std::string>();
}

std::int64_t integer(Json const& json, char const* key)
{
    auto const& v = value(json, key);
    bool const large = v.is_number_unsigned() &&
                       v.get<std::uint64_t>() > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    if (!v.is_number_integer() || large) throw WrongForm{fmt::format("{} is no integer", key)};
    return v.get<std::int64_t>();
}

Digest digest(Json const& json, char const* key)
{
    auto const d = digest_from_hex(word(json, key));
    if (!d) throw WrongForm{fmt::format("{} is not 32 hexadecimal digits", key)};
    return *d;
}

CheckpointPart part(Json const& json)
{
    auto const& bytes = value(json, "bytes");
    if (!bytes.is_number_unsigned()) throw WrongForm{"bytes is no length"};
    return {word(json, "member"), bytes.get<std::uint64_t>(), digest(json, "xxh3")};
}

Manifest manifest(Json const& json)
{
    if (integer(json, "format") != format) throw WrongForm{fmt::format("its format is not {}", format)};
    Manifest m;
    m.version = word(json, "sluice");
    auto const scene = from_hex(word(json, "scene"));
    if (!scene) throw WrongForm{"scene is not 16 hexadecimal digits"};
    m.scene = *scene;
    m.window = integer(json, "window");
    m.ticks = integer(json, "ticks");
    auto const& tick = value(json, "tick");
    if (!tick.is_number()) throw WrongForm{"tick is no number"};
    m.tick = tick.get<double>();
    if (!value(json, "previous").is_null()) m.previous = integer(json, "previous");
    auto const& members = value(json, "members");
    if (!members.is_array() || members.size() > Manifest::most_members) throw WrongForm{"members is no list of them"};
    for (auto const& member : members) m.members.push_back(part(member));
    return m;
}

Json parsed(std::string_view text)
{
    auto const bounded = [](int depth, Json::parse_event_t, Json&) {
        if (depth > deepest) throw WrongForm{"nested too deeply"};
        return true;
    };
    auto json = Json::parse(text, bounded, false);
    if (json.is_discarded()) throw WrongForm{"not JSON"};
    return json;
}

}  // namespace

bool is_member(std::string_view name)
{
    auto const colon = std::min(name.find(':'), name.size());
    auto const participant = name.substr(0, colon);
    bool const named = !participant.empty() && participant.size() <= 64 &&
                       participant.find_first_not_of(
                           "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                           "0123456789_-") == std::string_view::npos;
    if (colon == name.size()) return named;
    auto const rank = name.substr(colon + 1);
    return named && !rank.empty() && rank.size() <= 6 &&
           rank.find_first_not_of("0123456789") == std::string_view::npos && (rank == "0" || rank[0] != '0');
}

std::string CheckpointPart::line() const
{
    return fmt::format("{} {} {}", member, bytes, hex(digest));
}

std::optional<CheckpointPart> CheckpointPart::parse(std::string_view line)
{
    auto const first = line.find(' '), second = line.rfind(' ');
    if (first == std::string_view::npos || first == second) return std::nullopt;
    CheckpointPart part{std::string(line.substr(0, first)), 0, {}};
    std::from_chars(line.data() + first + 1, line.data() + second, part.bytes);
    if (auto const digest = digest_from_hex(line.substr(second + 1))) part.digest = *digest;
    if (!is_member(part.member) || part.line() != line) return std::nullopt;
    return part;
}

CheckpointPart const* Manifest::part_of(std::string_view member) const
{
    auto const found =
        std::find_if(members.begin(), members.end(), [&](CheckpointPart const& p) { return p.member == member; });
    return found == members.end() ? nullptr : &*found;
}

std::string Manifest::text() const
{
    auto const rule = broken_rule(*this);
    require(rule.empty(), [&] {
        return Error(fmt::format("checkpoint of window {}: {}. This is a bug of Sluice.", window, rule),
                     Exit::internal);
    });
    auto const covered = covered_text(*this);
    return with_digest(covered, hex(digest_of_text(covered)));
}

Manifest Manifest::parse(std::string_view text, std::string const& where)
{
    auto refuse = [&](std::string const& why) {
        throw Error(fmt::format("{}: {} (needs a manifest as Sluice writes it).", where, why), Exit::io);
    };
    if (text.size() > longest_text) refuse("too long");
    if (text.size() < digest_line) refuse("cut off");
    auto const covered = text.substr(0, text.size() - digest_line);
    auto const stated = text.substr(text.size() - 36, 32);
    if (text.substr(covered.size()) != with_digest("", stated)) refuse("cut off, or not a manifest");
    auto const digest = digest_from_hex(stated);
    if (!digest) refuse("its checksum is none");
    if (!checksum_fits(*digest, digest_of_text(covered))) refuse("its checksum is wrong");
    try {
        auto m = manifest(parsed(text));
        auto const rule = broken_rule(m);
        if (!rule.empty()) refuse(rule);
        if (with_digest(covered_text(m), stated) != text) refuse("not in the form that Sluice writes");
        return m;
    } catch (WrongForm const& form) {
        refuse(form.why);
    }
    return {};
}

}  // namespace sluice
