#include "coupler/cli/run_record.hpp"

#include <nlohmann/json.hpp>

#include "coupler/base/error.hpp"
#include "coupler/record/atomic_file.hpp"

namespace sluice {

void RunRecord::write(std::filesystem::path const& run) const
{
    nlohmann::ordered_json const record = {
        {"scene", scene.string()}, {"started", started.string()}, {"set", set}, {"parts", parts}};
    write_atomically(file(run), record.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

RunRecord RunRecord::read(std::filesystem::path const& run)
{
    require(std::filesystem::exists(file(run)), [&] {
        return Error(run.string() + ": no .sluice/run.json (needed: the directory of a run that `sluice run` began).",
                     Exit::io);
    });
    auto const record = nlohmann::json::parse(read_file(file(run)), nullptr, false);
    try {
        return {.scene = record.at("scene").get<std::string>(),
                .started = record.at("started").get<std::string>(),
                .set = record.at("set").get<std::vector<std::string>>(),
                .parts = record.at("parts").get<std::vector<double>>()};
    } catch (nlohmann::json::exception const&) {  // something else than write() writes
        throw Error(file(run).string() + ": damaged (needed: what `sluice run` wrote). Start the run anew.", Exit::io);
    }
}

}  // namespace sluice
