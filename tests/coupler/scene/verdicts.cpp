// Reads scenes from standard input, one after the other, each ended by a line with a record separator (byte 30), and
// prints for each a line: the validator's mistakes, tab between them; an empty line if there are none.

#include <cstdio>
#include <iostream>
#include <string>

#include "coupler/base/error.hpp"
#include "coupler/scene/scene.hpp"

namespace {

void judge(std::string const& text)
{
    std::string line;
    try {
        auto const loaded = sluice::load_scene_text(text, "scene.yaml");
        for (auto const& problem : loaded.diagnostics->problems) line += (line.empty() ? "" : "\t") + problem.text;
    } catch (sluice::Error const& e) {
        line = e.what();
    }
    for (char& c : line)
        if (c == '\n') c = ' ';
    std::puts(line.c_str());
}

}  // namespace

int main()
{
    std::string text;
    for (std::string line; std::getline(std::cin, line);) {
        if (line != "\x1e") {
            text += line + "\n";
            continue;
        }
        judge(text);
        text.clear();
    }
}
