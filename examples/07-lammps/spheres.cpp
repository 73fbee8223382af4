#include <lammps/library.h>

#include <fstream>
#include <map>

#include "coupler/coupler.hpp"

namespace {

//! LAMMPS as a library; what goes wrong in it becomes our error.
class Lammps
{
 public:
    explicit Lammps(std::string log)
    {
        std::vector<std::string> words{"lammps", "-log", log, "-screen", "none"};
        std::vector<char*> argv;
        for (auto& word : words) argv.push_back(word.data());
        handle_ = lammps_open_no_mpi(static_cast<int>(argv.size()), argv.data(), nullptr);
    }
    ~Lammps() { lammps_close(handle_); }
    Lammps(Lammps const&) = delete;

    void* handle() const { return handle_; }
    void command(std::string const& text)
    {
        lammps_command(handle_, text.c_str());
        if (lammps_has_error(handle_) == 0) return;
        char why[512];
        lammps_get_last_error_message(handle_, why, sizeof why);
        throw sluice::Error("LAMMPS stops at `" + text + "`: " + why);
    }
    int grains() const { return *static_cast<int*>(lammps_extract_global(handle_, "nlocal")); }
    int const* tags() const { return static_cast<int*>(lammps_extract_atom(handle_, "id")); }
    double** vectors(char const* name) const { return static_cast<double**>(lammps_extract_atom(handle_, name)); }
    double const* radii() const { return static_cast<double*>(lammps_extract_atom(handle_, "radius")); }

 private:
    void* handle_;
};

//! What the partner does, for `fix external`, which asks at the end of every step.
struct Loads
{
    Lammps const* lammps;
    sluice::Sampled<sluice::Load>* sampled = nullptr;  //!< null: none yet
    double time = 0.0, step = 0.0;                     //!< s

    static void add(void* self, std::int64_t, int count, int* tags, double**, double** force)
    {
        auto& loads = *static_cast<Loads*>(self);
        for (int i = 0; i < count; ++i) force[i][0] = force[i][1] = force[i][2] = 0.0;
        if (!loads.sampled) return;
        auto const load = loads.sampled->at(loads.time += loads.step);
        double** const torque = loads.lammps->vectors("torque");
        std::map<std::int64_t, std::size_t> place;  // by id; in the first window the fluid knows of none
        for (std::size_t k = 0; k < load.id.size(); ++k) place[load.id[k]] = 3 * k;
        for (int i = 0; i < count; ++i)
            if (auto const found = place.find(tags[i]); found != place.end())
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    force[i][axis] = load.force[found->second + axis];
                    torque[i][axis] += load.torque[found->second + axis];
                }
    }
};

void tell(sluice::Participant& self, std::string const& fluid, Lammps const& lammps)
{
    std::vector<std::int64_t> id;
    std::vector<double> position, velocity, spin, radius;
    for (int i = 0; i < lammps.grains(); ++i) {
        id.push_back(lammps.tags()[i]);
        radius.push_back(lammps.radii()[i]);
        for (auto const& [column, name] : {std::pair{&position, "x"}, {&velocity, "v"}, {&spin, "omega"}})
            column->insert(column->end(), lammps.vectors(name)[i], lammps.vectors(name)[i] + 3);
    }
    self.write(fluid, sluice::Kinematics{id, position, velocity, spin, radius});
}

void solve(sluice::Participant& self)
{
    self.sends({"kinematics"});
    self.takes({"load"});
    auto keys = self.config();
    auto const script = self.scene().file.parent_path() / keys.text("script");
    double const step = keys.number("step", {.above = 0.0, .unit = "s"});
    keys.finish();
    if (self.checking()) return;
    Lammps lammps(self.directory() / (self.name() + ".lammps.log"));
    std::ifstream in(script);
    for (std::string line; std::getline(in, line);) lammps.command(line);
    Loads loads{&lammps};
    lammps.command("fix partner all external pf/callback 1 1");
    lammps_set_fix_external_callback(lammps.handle(), "partner", Loads::add, &loads);
    lammps.command("run 0 post no");
    auto const fluid = self.receivers("kinematics").at(0);
    tell(self, fluid, lammps);
    for (sluice::Window const& window : self.windows()) {
        auto sampled = self.read<sluice::Load>(fluid, window);
        auto const steps = window.steps(step);
        double const dt = window.length / static_cast<double>(steps);
        if (dt != loads.step) {  // what LAMMPS has set up for the old one is not right any more
            loads.sampled = nullptr;
            lammps.command("timestep " + std::to_string(dt * 1e9) + "e-9");
            lammps.command("run 0 post no");
        }
        loads = {&lammps, &sampled, window.begin, dt};
        lammps.command("run " + std::to_string(steps) + " pre no post no");
        tell(self, fluid, lammps);
    }
    self.fact("height at the end [m]", lammps.vectors("x")[0][2]);
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, solve);
}
