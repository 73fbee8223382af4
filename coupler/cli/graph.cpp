#include "coupler/cli/graph.hpp"

#include <fmt/format.h>

#include "coupler/base/error.hpp"
#include "coupler/cli/process.hpp"
#include "coupler/record/atomic_file.hpp"

namespace sluice {
namespace {

std::string quoted(std::string const& text)
{
    std::string result = "\"";
    for (char c : text) {
        if (c == '"' || c == '\\') result += '\\';
        if (c == '\n')
            result += "\\n";
        else
            result += c;
    }
    return result + "\"";
}

}  // namespace

std::string to_dot(Scene const& scene)
{
    std::string dot = "digraph scene {\n  rankdir=LR;\n  label=" + quoted(scene.title) +
                      ";\n  fontname=\"Helvetica\";\n  node [shape=box, style=rounded, fontname=\"Helvetica\"];\n"
                      "  edge [fontname=\"Helvetica\", fontsize=10];\n";
    for (auto const& p : scene.participants)
        dot += "  " + quoted(p.name) +
               " [label=" + quoted(p.name + "\n" + (p.solver.empty() ? p.command.at(0) : p.solver)) + "];\n";
    constexpr char const* orders[] = {"", ", linear prediction", ", quadratic prediction"};
    for (Edge const& e : scene.edges) {
        auto const& data = scene.data[static_cast<std::size_t>(e.data)];
        std::string columns;
        for (auto const& c : data.columns) columns += (columns.empty() ? "" : ", ") + c.name + " [" + c.unit + "]";
        dot +=
            fmt::format("  {} -> {} [label={}{}];\n", quoted(scene.participants[static_cast<std::size_t>(e.from)].name),
                        quoted(scene.participants[static_cast<std::size_t>(e.to)].name),
                        quoted(fmt::format("{}\nlag {}{}\n{}", data.name, e.lag, orders[e.predict], columns)),
                        e.lag == 1 ? ", style=dashed" : "");
    }
    return dot + "}\n";
}

void draw(std::string const& dot, std::filesystem::path const& picture)
{
    require(!find_executable("dot").empty(), [] {
        return Error("graphviz is not installed (package graphviz). Without -o the DOT text is printed.", Exit::io);
    });
    auto const format = picture.extension().string();
    require(format == ".svg" || format == ".png" || format == ".pdf",
            [&] { return Error(picture.string() + ": must end in .svg, .png or .pdf."); });
    auto const source = picture.string() + ".dot";
    auto const log = picture.string() + ".log";
    write_atomically(source, dot);
    Process dot_process({"dot", "-T" + format.substr(1), source, "-o", picture.string()}, log);
    bool const well = dot_process.wait().well();
    auto const said = last_lines(log, 5);
    std::filesystem::remove(source);
    std::filesystem::remove(log);
    require(well, [&] { return Error(picture.string() + ": graphviz failed." + said, Exit::io); });
}

}  // namespace sluice
