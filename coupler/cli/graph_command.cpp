#include <cstdio>

#include "coupler/cli/answers.hpp"
#include "coupler/cli/commands.hpp"
#include "coupler/cli/graph.hpp"

namespace sluice {

int graph_command(Options const& o)
{
    auto const loaded = load_scene(o.choice.scene, o.choice.overrides);
    loaded.diagnostics->throw_if_any();
    if (!o.picture.empty()) draw(to_dot(loaded.scene), o.picture);
    if (o.json)
        print_json(topology(loaded.scene));
    else if (o.picture.empty())
        std::fputs(to_dot(loaded.scene).c_str(), stdout);
    return 0;
}

}  // namespace sluice
