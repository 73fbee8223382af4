#include "participants/dem/series_averages.hpp"

#include <optional>

#include "participants/dem/stress.hpp"

namespace dem {
namespace {

//! Calls `visit(a, b)` for the components of a tensor, of a symmetric one once each.
template <int D, class Visit>
void each_component(bool symmetric, Visit&& visit)
{
    for (int a = 0; a < D; ++a)
        for (int b = symmetric ? a : 0; b < D; ++b) visit(a, b);
}

}  // namespace

template <int D>
std::vector<std::string> average_names(Config const& config)
{
    std::vector<std::string> names;
    if (config.periodic.is_sheared()) names = {"shear_strain", "cell_height [m]"};
    for (AverageConfig const& of : config.averages) {
        auto const add = [&](char const* what, bool symmetric, char const* unit) {
            each_component<D>(symmetric, [&](int a, int b) {
                names.push_back(of.name + "_" + what + "_" + "xyz"[a] + "xyz"[b] + unit);
            });
        };
        add("stress", false, " [Pa]");
        add("kinetic_stress", true, " [Pa]");
        add("fabric", true, "");
        names.push_back(of.name + "_packing_fraction");
    }
    return names;
}

template <int D>
void append_averages(Config const& config, Solver<D> const& solver, std::vector<double>& row)
{
    Cell<D> const& cell = solver.state().cell;
    if (config.periodic.is_sheared())
        row.insert(row.end(), {cell.strain, component(cell.extent, config.periodic.shear.across)});
    for (AverageConfig const& of : config.averages) {
        std::optional<Box<D>> box;
        if (!of.whole) box = Box<D>{to_dimension<D>(of.low), to_dimension<D>(of.high)};
        auto const a = averages(solver.setup(), solver.state(), box);
        auto const add = [&](Tensor<D> const& tensor, bool symmetric) {
            each_component<D>(symmetric,
                              [&](int i, int j) { row.push_back(component(tensor[static_cast<std::size_t>(i)], j)); });
        };
        add(a.contact, false);
        add(a.kinetic, true);
        add(a.fabric, true);
        row.push_back(a.packing_fraction);
    }
}

template std::vector<std::string> average_names<2>(Config const&);
template std::vector<std::string> average_names<3>(Config const&);
template void append_averages<2>(Config const&, Solver<2> const&, std::vector<double>&);
template void append_averages<3>(Config const&, Solver<3> const&, std::vector<double>&);

}  // namespace dem
