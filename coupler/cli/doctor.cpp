#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "coupler/base/error.hpp"
#include "coupler/cli/answers.hpp"
#include "coupler/cli/commands.hpp"
#include "coupler/cli/findings.hpp"

namespace sluice {

int doctor_command(Options const& o)
{
    auto const findings = examine();
    constexpr char const* words[] = {"ok", "warn", "fail"};
    auto list = nlohmann::ordered_json::array();
    int fails = 0, warnings = 0;
    for (Finding const& f : findings) {
        auto const state = words[static_cast<int>(f.state)];
        fails += f.state == Finding::State::fail;
        warnings += f.state == Finding::State::warn;
        if (o.json)
            list.push_back({{"what", f.what}, {"state", state}, {"found", f.found}, {"advice", f.advice}});
        else
            std::printf("%s\n", fmt::format("{:<5} {:<16} {}{}", state, f.what, f.found,
                                            f.advice.empty() ? "" : "\n" + std::string(23, ' ') + f.advice)
                                    .c_str());
    }
    if (o.json)
        print_json({{"version", SLUICE_VERSION}, {"ok", fails == 0}, {"findings", list}});
    else
        std::printf(
            "%s\n",
            fmt::format("{} looked at: {} to be repaired, {} worth a look", findings.size(), fails, warnings).c_str());
    return fails == 0 ? 0 : static_cast<int>(Exit::io);
}

}  // namespace sluice
