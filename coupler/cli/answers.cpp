#include "coupler/cli/answers.hpp"

#include <charconv>
#include <cstdio>
#include <sstream>

namespace sluice {
namespace {

using Json = nlohmann::ordered_json;

//! `:12:5: text` after a file's name; nothing if the line does not go on like that.
Json placed(std::string_view rest)
{
    int place[2] = {};
    for (int& number : place) {
        if (!rest.starts_with(':')) return nullptr;
        rest.remove_prefix(1);
        auto const [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
        if (error != std::errc()) return nullptr;
        rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    }
    if (!rest.starts_with(": ")) return nullptr;
    return {{"line", place[0]}, {"column", place[1]}, {"text", rest.substr(2)}};
}

}  // namespace

Json mistakes_of(std::string const& message)
{
    Json list = Json::array();
    std::istringstream lines(message);
    for (std::string line; std::getline(lines, line);) {
        Json found = nullptr;
        std::size_t name = 0;
        for (auto at = line.find(':'); at != line.npos && found.is_null(); at = line.find(':', at + 1)) {
            found = placed(std::string_view(line).substr(at));
            name = at;
        }
        if (found.is_null())
            list.push_back({{"text", line}});
        else {
            found["file"] = line.substr(0, name);
            list.push_back(found);
        }
    }
    return list;
}

Json topology(Scene const& scene)
{
    constexpr char const* predictions[] = {"none", "linear", "quadratic"};
    auto const name = [&](int p) { return scene.participants[static_cast<std::size_t>(p)].name; };
    Json participants = Json::array(), couplings = Json::array(), groups = Json::array();
    for (auto const& p : scene.participants) {
        Json entry = {{"name", p.name}, {"ranks", p.ranks}};
        p.command.empty() ? entry["solver"] = p.solver : entry["command"] = p.command;
        if (!p.host.empty()) entry["host"] = p.host;
        participants.push_back(entry);
    }
    for (Edge const& e : scene.edges) {
        auto const& data = scene.data[static_cast<std::size_t>(e.data)];
        Json columns = Json::array();
        for (auto const& c : data.columns)
            columns.push_back({{"name", c.name}, {"unit", c.unit}, {"numbers", components(c.shape, scene.dimension)}});
        couplings.push_back({{"from", name(e.from)},
                             {"to", name(e.to)},
                             {"data", data.name},
                             {"lag", e.lag},
                             {"predict", predictions[e.predict]},
                             {"columns", columns}});
    }
    for (auto const& group : scene.implicit) {
        Json members = Json::array();
        for (int p : group.participants) members.push_back(name(p));
        groups.push_back(members);
    }
    return {{"title", scene.title},
            {"dimension", scene.dimension},
            {"participants", participants},
            {"couplings", couplings},
            {"implicit", groups}};
}

void print_json(Json const& value)
{
    std::printf("%s\n", value.dump(1, ' ', false, Json::error_handler_t::replace).c_str());
}

}  // namespace sluice
