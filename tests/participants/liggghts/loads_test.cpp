#include "participants/liggghts/loads.hpp"

#include <doctest/doctest.h>

#include <array>

namespace {

using liggghts::Loads;

//! Grains as LIGGGHTS has them: on each acts its tag, in all six numbers; they move with velocity 1, spin 2.
struct Fake
{
    explicit Fake(std::vector<int> const& tags) : tag(tags)
    {
        for (auto* column : {&force, &torque, &velocity, &spin}) column->resize(3 * tag.size());
        for (std::size_t k = 0; k < force.size(); ++k) {
            force[k] = torque[k] = tag[k / 3];
            velocity[k] = 1.0;
            spin[k] = 2.0;
        }
    }
    liggghts::Rows rows()
    {
        for (std::size_t i = 0; i < tag.size(); ++i) {
            pointers[0][i] = &force[3 * i];
            pointers[1][i] = &torque[3 * i];
            pointers[2][i] = &velocity[3 * i];
            pointers[3][i] = &spin[3 * i];
        }
        liggghts::Rows r;
        r.count = static_cast<int>(tag.size());
        r.tag = tag.data();
        r.force = pointers[0].data();
        r.torque = pointers[1].data();
        r.velocity = pointers[2].data();
        r.spin = pointers[3].data();
        return r;
    }

    std::vector<int> tag;
    std::vector<double> force, torque, velocity, spin;
    std::array<std::array<double*, 4>, 4> pointers{};
};

//! On each of these tags a force of 10 and a torque of 100 times its tag, in x, y and z.
Loads loads_on(std::vector<int> const& tags)
{
    std::vector<double> force, torque;
    for (int const tag : tags) {
        force.insert(force.end(), 3, 10.0 * tag);
        torque.insert(torque.end(), 3, 100.0 * tag);
    }
    Loads loads;
    loads.set(tags, force, torque);
    return loads;
}

void check_each(Fake const& grains, std::vector<double> const& force, std::vector<double> const& torque)
{
    for (std::size_t k = 0; k < grains.force.size(); ++k) {
        CAPTURE(k);
        CHECK(grains.force[k] == force[k / 3]);
        CHECK(grains.torque[k] == torque[k / 3]);
    }
}

}  // namespace

TEST_CASE("loads: act on their own grain, whatever the order of the rows, one without has none")
{
    Loads loads = loads_on({4, 2, 3});
    Fake same({4, 2, 3}), other({3, 5, 4, 1}), again({2, 1, 3});
    loads.add_to(same.rows());
    check_each(same, {44, 22, 33}, {404, 202, 303});
    loads.add_to(other.rows());
    check_each(other, {33, 5, 44, 1}, {303, 5, 404, 1});
    loads.add_to(again.rows());
    check_each(again, {22, 1, 33}, {202, 1, 303});
    Fake none({});
    loads.add_to(none.rows());
}

TEST_CASE("loads: one in the place of another, on the same grains or others")
{
    Fake grains({4, 2, 3});
    Loads first = loads_on({2, 3, 4}), second = loads_on({2, 3, 4}), third = loads_on({3, 4});
    for (double& f : second.force) f *= 2.0;
    first.add_to(grains.rows());
    second.replace(grains.rows(), first);
    check_each(grains, {84, 42, 63}, {404, 202, 303});
    third.replace(grains.rows(), second);
    check_each(grains, {44, 2, 33}, {404, 2, 303});
}

TEST_CASE("loads: power and mean")
{
    Fake grains({3, 2, 9});
    Loads a = loads_on({2, 3}), b = loads_on({2, 3}), mean;
    CHECK(a.power(grains.rows()) == 3 * (1.0 * 10.0 * (2 + 3) + 2.0 * 100.0 * (2 + 3)));
    b.reset(b.tags());
    mean.set_mean(a, b);
    CHECK(mean.tags() == a.tags());
    CHECK(mean.force[3] == 15.0);
    CHECK(mean.torque[0] == 100.0);
}
