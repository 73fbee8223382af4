#pragma once

#include <array>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "coupler/base/scratch_directory.hpp"
#include "coupler/record/atomic_file.hpp"
#include "coupler/scene/reader.hpp"
#include "participants/dem/setup.hpp"
#include "participants/liggghts/drive.hpp"
#include "participants/liggghts/engine.hpp"
#include "participants/liggghts/mirror.hpp"
#include "participants/liggghts/script.hpp"
#include "participants/liggghts/source.hpp"

//! A block of keys in the one LIGGGHTS that a process can have.
namespace liggghts_scene {

//! Its files, and LIGGGHTS itself, from the first scene on.
struct Place
{
    sluice::ScratchDirectory folder{"sluice-liggghts"};
    liggghts::Engine engine{folder.path() / "log", 0, 1};
};
inline Place& place()
{
    static Place only;
    return only;
}

inline dem::Config read(std::string const& keys, int dimension, dem::Vec3 gravity = {})
{
    return dem::read_config(sluice::read_yaml(keys, "scene.yaml"), dimension, gravity);
}

//! Loads on the tags 1, 2, ...: force, then torque [N, N m].
inline liggghts::Loads loads_of(std::vector<std::array<double, 6>> const& acting)
{
    std::vector<int> tags;
    std::vector<double> force, torque;
    for (auto const& load : acting) {
        tags.push_back(static_cast<int>(tags.size()) + 1);
        force.insert(force.end(), load.begin(), load.begin() + 3);
        torque.insert(torque.end(), load.begin() + 3, load.end());
    }
    liggghts::Loads loads;
    loads.set(tags, force, torque);
    return loads;
}

template <int D>
class Scene
{
 public:
    explicit Scene(dem::Config config) : config_(std::move(config)), start_(dem::listed_grains<D>(config_))
    {
        auto& [folder, engine] = place();
        std::vector<double> radius;
        for (auto const& grain : start_.place) radius.push_back(grain.radius);
        auto const classes = liggghts::classes_of(start_.mass, radius, liggghts::most_classes);
        auto const data = folder.path() / "data", script = folder.path() / "in";
        sluice::write_atomically(data, liggghts::data_of(config_, start_, classes));
        sluice::write_atomically(script,
                                 liggghts::script_of(config_, classes, "read_data \"" + data.string() + '"', 0.0));
        engine.command("clear", "scene");  // what an earlier scene left
        liggghts::run_script(engine, script, {});
        drive_.begin();
    }

    dem::Config const& config() const { return config_; }
    liggghts::Drive& drive() { return drive_; }
    //! As they are now.
    dem::Grains<D> grains() const { return liggghts::Mirror<D>(start_.id, place().engine.rows()).grains(); }
    //! Steps of dt [s] without loads.
    void run(std::int64_t steps, double dt)
    {
        drive_.advance(
            steps, dt, [](std::int64_t, auto& loads) { loads.reset({}); }, false);
    }

 private:
    dem::Config config_;
    dem::Grains<D> start_;
    liggghts::Drive drive_{place().engine};
};

}  // namespace liggghts_scene
