#include "tests/simulation/course.hpp"

#include <fmt/format.h>

namespace simulation {
namespace {

constexpr std::chrono::seconds longest{30};  // virtual; connecting may take 1 s, each silence 0.5 s

struct Seat
{
    int participant, rank;
    std::string name;
};

std::vector<Seat> seats_of(Topology const& topology)
{
    std::vector<Seat> seats;
    for (std::size_t p = 0; p < topology.parts.size(); ++p)
        for (int r = 0; r < topology.parts[p].ranks; ++r)
            seats.push_back({static_cast<int>(p), r, topology.scene->scene.participants[p].name});
    return seats;
}

void live(Topology const& topology, Seat const& seat, int member, std::int64_t work,
          std::unique_ptr<Transport> transport, World& world, Course::Ending& ending)
{
    ending = {};
    std::optional<sluice::Error> error;
    try {
        sluice::JoinOptions options;
        options.name = seat.name;
        options.rank = seat.rank;
        options.transport = std::move(transport);
        options.given = topology.scene;
        sluice::Participant self(std::move(options));
        try {
            solve(self, topology, seat.participant, member, work, world, ending.record);
            ending.exit = self.finish();
            ending.well = true;
        } catch (sluice::Error const& e) {
            error = e;
        }
        if (error) self.fail(*error);  // not inside the catch block: it sends, and others run meanwhile
    } catch (sluice::Error const& e) {
        error = e;
    } catch (std::exception const& e) {
        ending.record.broken.push_back(std::string("an exception that is no Error: ") + e.what());
    }
    if (!error) return;
    ending.exit = static_cast<int>(error->exit());
    ending.error = error->what();
}

bool names_somebody(Topology const& topology, std::string const& text)
{
    for (auto const& spec : topology.scene->scene.participants)
        if (text.find('"' + spec.name) != text.npos) return true;
    return false;
}

Conditions random_conditions(Random& random, Course const& calm)
{
    Conditions conditions;
    static constexpr std::int64_t delays[] = {0, 100, 2'000, 30'000};
    static constexpr std::size_t capacities[] = {1, 2, 8, 64};
    conditions.delay = delays[random.below(4)];
    conditions.nap = random.one_in(2) ? 0 : delays[random.below(4)];
    conditions.capacity = capacities[random.below(4)];
    conditions.refuses_dead = random.one_in(2);
    std::int64_t const strikes = random.one_in(4) ? 0 : random.one_in(4) ? random.between(2, 3) : 1;
    for (std::int64_t k = 0; k < strikes; ++k)
        conditions.strikes.push_back({random.below(calm.messages + 4),
                                      static_cast<Fault>(random.below(static_cast<std::int64_t>(Fault::count)))});
    return conditions;
}

//! What a schedule's number stands for.
struct Schedule
{
    std::uint64_t topology, course;
    explicit Schedule(std::int64_t number)
        : topology(Random(static_cast<std::uint64_t>(number / schedules_per_topology)).next()),
          course(Random(static_cast<std::uint64_t>(number) ^ 0x5111ce).next())
    {}
};

Course run_schedule(Topology const& topology, Schedule const& schedule, Course const& calm, Conditions& conditions,
                    Fibers& fibers)
{
    Random random(schedule.course);
    conditions = random_conditions(random, calm);
    return run_course(topology, random.next(), conditions, random.one_in(3) ? 0 : 20'000, fibers);
}

}  // namespace

Course run_course(Topology const& topology, std::uint64_t seed, Conditions const& conditions, std::int64_t work,
                  Fibers& fibers)
{
    auto const seats = seats_of(topology);
    Course course{.endings = std::vector<Course::Ending>(seats.size())};
    World* world = nullptr;
    World here(fibers, seed, static_cast<int>(seats.size()), conditions,
               [&](int member, std::unique_ptr<Transport> transport) {
                   auto const at = static_cast<std::size_t>(member);
                   live(topology, seats[at], member, work, std::move(transport), *world, course.endings[at]);
               });
    world = &here;
    auto const start = here.now();
    course.ended = here.run(longest);
    for (std::size_t m = 0; m < seats.size(); ++m) course.endings[m].crashed = here.crashed(static_cast<int>(m));
    course.messages = here.messages();
    course.struck = here.struck();
    course.seconds = std::chrono::duration<double>(here.now() - start).count();
    return course;
}

std::string broken_rule(Topology const& topology, Course const& course, Course const& calm)
{
    if (!course.ended) return "it does not end";
    for (std::size_t m = 0; m < course.endings.size(); ++m) {
        auto const& ending = course.endings[m];
        if (!ending.record.broken.empty()) return ending.record.broken.front();
        if (ending.crashed) continue;
        if (!ending.well) {
            if (course.struck == 0) return "nothing was done to it, and yet: " + ending.error;
            if (ending.exit < 3 || ending.exit > 6) return fmt::format("exit code {}: {}", ending.exit, ending.error);
            if (!names_somebody(topology, ending.error)) return "an error that names nobody: " + ending.error;
            continue;
        }
        auto const& right = calm.endings[m].record;
        if (ending.exit != 0) return fmt::format("ended well with exit code {}", ending.exit);
        if (ending.record.times != right.times || ending.record.times != calm.endings[0].record.times)
            return fmt::format("member {} ended well, with other windows", m);
        if (ending.record.states != right.states) return fmt::format("member {} ended well, with other states", m);
    }
    return {};
}

Tally run_schedules(std::int64_t first, std::int64_t count)
{
    Tally tally;
    Fibers fibers;
    std::unique_ptr<Topology> topology;
    Course calm;
    for (std::int64_t number = first; number < first + count; ++number) {
        Schedule const schedule(number);
        if (!topology || number % schedules_per_topology == 0) {
            topology = std::make_unique<Topology>(schedule.topology);
            calm = run_course(*topology, 1, {}, 0, fibers);
            tally.broken = broken_rule(*topology, calm, calm);
        }
        if (tally.broken.empty()) {
            Conditions conditions;
            auto const course = run_schedule(*topology, schedule, calm, conditions, fibers);
            tally.broken = broken_rule(*topology, course, calm);
            tally.faulty += course.struck > 0;
            for (auto const& ending : course.endings)
                if (!ending.well) {
                    ++tally.failed;
                    break;
                }
        }
        if (!tally.broken.empty()) {
            tally.broken = fmt::format("schedule {}: {}", number, tally.broken);
            return tally;
        }
        ++tally.schedules;
    }
    return tally;
}

std::string describe_schedule(std::int64_t number)
{
    Schedule const schedule(number);
    Fibers fibers;
    Topology const topology(schedule.topology);
    auto const calm = run_course(topology, 1, {}, 0, fibers);
    Conditions conditions;
    auto const course = run_schedule(topology, schedule, calm, conditions, fibers);
    auto text = topology.text + fmt::format("adaptive {}, early {}\n", topology.adaptive, topology.early);
    for (auto const& part : topology.parts)
        text += fmt::format("ranks {}, points {}{}{}\n", part.ranks, part.points, part.moves ? ", moves" : "",
                            part.changes ? ", changes" : "");
    text += fmt::format("delay {} us, nap {} us, capacity {}, refuses {}\n", conditions.delay, conditions.nap,
                        conditions.capacity, conditions.refuses_dead);
    for (auto const& strike : conditions.strikes)
        text += fmt::format("message {} of {}: {}\n", strike.message, calm.messages, to_text(strike.fault));
    for (auto const* each : {&calm, &course}) {
        text += fmt::format("{} messages, {} faults, {:.3f} s, {}\n", each->messages, each->struck, each->seconds,
                            each->ended ? "ended" : "HANGS");
        for (auto const& e : each->endings)
            text += fmt::format("  {} {} windows, states {:016x} {}\n",
                                e.crashed ? "crashed"
                                : e.well  ? "well"
                                          : "failed",
                                e.record.times.size() - 1, e.record.states, e.error);
    }
    return text + "rule: " + broken_rule(topology, course, calm) + "\n";
}

}  // namespace simulation
