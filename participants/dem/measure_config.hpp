#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "coupler/scene/reader.hpp"
#include "participants/dem/front.hpp"

//! What a scene wants to have measured while it runs.
namespace dem {

struct Config;

enum class Measure : unsigned char
{
    run_out,       //!< front, foremost grain, height
    energies,      //!< the ledger
    contacts,      //!< coordination, number, largest overlap
    centre,        //!< of mass
    impulse,       //!< that the fluid gave in the last window
    drift,         //!< of the ledger's sum
    front,         //!< of a round column, by sectors
    coordination,  //!< grains by number of contacts
    profile,       //!< mass and surface along the run-out direction
    voronoi,       //!< local packing fraction
    force_chains   //!< contacts as lines
};
inline constexpr std::array<std::string_view, 11> measure_names{"run_out", "energies", "contacts",    "centre",
                                                                "impulse", "drift",    "front",       "coordination",
                                                                "profile", "voronoi",  "force_chains"};

struct Wanted
{
    bool wanted = false;
    double interval = 0.0;  //!< its own [s]; 0: that of the time series, of force chains that of the pictures
};

struct MeasuresConfig
{
    bool stated = false;  //!< the scene has the key: what it names also goes to an archive
    std::array<Wanted, measure_names.size()> of;
    Sectors sectors;
    std::size_t most_contacts = 12;  //!< the last class of the coordination numbers
    bool wall_contacts = true;       //!< count as contacts there
    double slice = 0.0;              //!< width of a slice of the profiles [m]; 0: two mean diameters
    bool radial = false;             //!< slices are rings about the axis of a round column

    Wanted& operator[](Measure m) { return of[static_cast<std::size_t>(m)]; }
    Wanted const& operator[](Measure m) const { return of[static_cast<std::size_t>(m)]; }
    //! Whether anything measured needs the dissipated energies. `series`: interval of the time series [s].
    bool need_ledger(double series) const;
};

//! The key `measures`; without it the five that the time series always had. After the column.
MeasuresConfig read_measures(sluice::Reader& reader, Config const& config);

}  // namespace dem
