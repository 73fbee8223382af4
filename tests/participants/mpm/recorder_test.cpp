#include "participants/mpm/recorder.hpp"

#include <doctest/doctest.h>

#include <string>

#include "coupler/base/scratch_directory.hpp"
#include "coupler/record/atomic_file.hpp"
#include "tests/support/contains.hpp"

namespace {

template <int D>
std::string header(mpm::Extras extras)
{
    sluice::ScratchDirectory const folder("sluice-test");
    mpm::Recorder<D> recorder({folder.path(), "soil", 0}, extras);
    recorder.close();
    return sluice::read_file(folder.path() / "soil.csv");
}

}  // namespace

TEST_CASE("recorder: energies are by metre in the plane, of the whole in space and of rings")
{
    auto const plane = header<2>({.field_work = true}), rings = header<2>({.field_work = true, .rings = true});
    for (std::string const energy : {"kinetic", "balance", "drift", "field_work"}) {
        CAPTURE(energy);
        CHECK(contains(plane, energy + " [J/m]"));
        CHECK(contains(rings, energy + " [J]"));
        CHECK(contains(header<3>({.field_work = true}), energy + " [J]"));
    }
    CHECK(!contains(rings, "[J/m]"));
    CHECK(contains(rings, "centre_x [m],centre_y [m],drift"));
}
