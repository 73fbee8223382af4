#include "coupler/cli/rehearsal.hpp"

#include <algorithm>
#include <deque>
#include <optional>

#include "coupler/schedule/schedule.hpp"

namespace sluice {
namespace {

//! A computation, by participant and its number there; who = -1: none. Times are in units of one computation.
struct Step
{
    int who = -1;
    std::size_t number = 0;
};

//! When something happened, and the computation that it had to wait for.
struct Moment
{
    int time = 0;
    Step after;
};

struct Letter
{
    std::int64_t frame = 0;
    std::uint32_t iteration = 0;
    Moment sent;
};

struct Player
{
    Schedule schedule;
    std::vector<int> in, out;  //!< its edges, in the order that its schedule knows; indices into Scene::edges
    Moment now;
    std::vector<Moment> computed;  //!< each computation: when it was done, and what it waited for
};

class Stage
{
 public:
    explicit Stage(Scene const& scene)
        : scene_(scene), windows_(2 * static_cast<int>(scene.participants.size()) + 4), mail_(scene.edges.size())
    {
        for (int p = 0; p < static_cast<int>(scene.participants.size()); ++p) {
            std::vector<InEdge> terms;
            std::vector<int> in, out;
            for (std::size_t e = 0; e < scene.edges.size(); ++e) {
                Edge const& edge = scene.edges[e];
                if (edge.from == p) out.push_back(static_cast<int>(e));
                if (edge.to != p) continue;
                in.push_back(static_cast<int>(e));
                terms.push_back({.lag = edge.lag, .predict = edge.predict, .inside = inside(edge)});
            }
            players_.push_back({Schedule(terms, group_of(p) != nullptr), in, out, {}, {}});
        }
    }

    //! Plays until everybody is through, or nobody can go on.
    void play()
    {
        for (bool moved = true; moved;) {
            moved = false;
            for (int p = 0; p < count(); ++p)
                while (act(p)) moved = true;
        }
    }

    bool through() const
    {
        return std::all_of(players_.begin(), players_.end(),
                           [](Player const& player) { return player.schedule.next().kind == Action::Kind::finish; });
    }

    //! What a participant that cannot go on waits for.
    std::string wait_of(int p) const
    {
        Action const action = player(p).schedule.next();
        auto const where = name(p) + " waits in window " + std::to_string(action.window) + " for ";
        if (action.kind == Action::Kind::plan) return where + "the plan of " + name(scene_.pace);
        if (action.kind == Action::Kind::agree) return where + "the others of its group";
        if (action.kind != Action::Kind::await) return "";
        Edge const& edge = edge_at(player(p).in[static_cast<std::size_t>(action.edge)]);
        return where + "frame " + std::to_string(action.frame) + " of " +
               scene_.data[static_cast<std::size_t>(edge.data)].name + " from " + name(edge.from);
    }

    //! The chain of computations that ended last, as far back as it takes to come round to the same participant again.
    std::vector<int> chain(double& per_window) const
    {
        int who = 0;
        for (int p = 1; p < count(); ++p)
            if (player(p).now.time > player(who).now.time) who = p;
        Step step{who, player(who).computed.size() - 1};
        auto const begin = step;
        std::vector<int> back;
        do {
            back.push_back(step.who);
            step = computation(step).after;
        } while (step.who >= 0 && step.who != begin.who);
        per_window = step.who < 0 ? 1
                                  : static_cast<double>(computation(begin).time - computation(step).time) /
                                        static_cast<double>(begin.number - step.number);
        std::reverse(back.begin(), back.end());
        std::rotate(back.begin(), std::min_element(back.begin(), back.end()), back.end());  // it is a circle
        return back;
    }

 private:
    int count() const { return static_cast<int>(players_.size()); }
    Player& player(int p) { return players_[static_cast<std::size_t>(p)]; }
    Player const& player(int p) const { return players_[static_cast<std::size_t>(p)]; }
    Edge const& edge_at(int e) const { return scene_.edges[static_cast<std::size_t>(e)]; }
    Moment const& computation(Step s) const { return player(s.who).computed[s.number]; }
    std::string const& name(int p) const { return scene_.participants[static_cast<std::size_t>(p)].name; }

    ImplicitGroup const* group_of(int p) const
    {
        for (ImplicitGroup const& group : scene_.implicit)
            if (group.has(p)) return &group;
        return nullptr;
    }
    bool inside(Edge const& e) const { return group_of(e.from) && group_of(e.from) == group_of(e.to); }

    //! Does what a participant has to do next; false if it has to wait, or is through.
    bool act(int p)
    {
        Player& me = player(p);
        Action const action = me.schedule.next();
        switch (action.kind) {
            case Action::Kind::send:
                for (int e : me.out)
                    if (action.frame == 0 || !inside(edge_at(e))) post(e, {action.frame, 0, me.now});
                me.schedule.sent();
                return true;
            case Action::Kind::plan:
                return plan(p, action.window);
            case Action::Kind::await:
                return take(me, action);
            case Action::Kind::compute:
                compute(p, action);
                return true;
            case Action::Kind::agree:
                return agree(p, action);
            default:  // nothing is stored here
                return false;
        }
    }
    void post(int e, Letter const& letter) { mail_[static_cast<std::size_t>(e)].push_back(letter); }

    static void wait_until(Player& me, Moment const& other)
    {
        if (other.time > me.now.time) me.now = other;
    }

    bool plan(int p, std::int64_t window)
    {
        if (p == scene_.pace && static_cast<std::int64_t>(plans_.size()) == window) plans_.push_back(player(p).now);
        if (static_cast<std::int64_t>(plans_.size()) <= window) return false;
        wait_until(player(p), plans_[static_cast<std::size_t>(window)]);
        player(p).schedule.planned({.window = window, .begin = window, .length = 1, .last = window + 1 == windows_});
        return true;
    }

    bool take(Player& me, Action const& action)
    {
        auto& box = mail_[static_cast<std::size_t>(me.in[static_cast<std::size_t>(action.edge)])];
        if (box.empty() || !me.schedule.received(action.edge, box.front().frame, box.front().iteration)) return false;
        wait_until(me, box.front().sent);
        box.pop_front();
        return true;
    }

    void compute(int p, Action const& action)
    {
        Player& me = player(p);
        me.computed.push_back({me.now.time + 1, me.now.after});
        me.now = {me.now.time + 1, {p, me.computed.size() - 1}};
        me.schedule.computed();
        for (int e : me.out)
            if (inside(edge_at(e))) post(e, {action.window + 1, action.iteration, me.now});
    }

    //! All of the group are there: the first window is repeated once, the others converge at once.
    bool agree(int p, Action const& action)
    {
        auto const& members = group_of(p)->participants;
        bool const all =
            std::all_of(members.begin(), members.end(), [&](int m) { return player(m).schedule.next() == action; });
        if (!all) return false;
        Moment latest;
        for (int m : members)
            if (player(m).now.time > latest.time) latest = player(m).now;
        for (int m : members) {
            wait_until(player(m), latest);
            player(m).schedule.agreed(action.window > 0 || action.iteration > 0);
        }
        return true;
    }

    Scene const& scene_;
    int windows_;
    std::vector<Player> players_;
    std::vector<std::deque<Letter>> mail_;  //!< per edge
    std::vector<Moment> plans_;             //!< when each window was planned
};

}  // namespace

Rehearsal rehearse(Scene const& scene)
{
    Rehearsal result;
    if (scene.participants.empty()) return result;
    Stage stage(scene);
    stage.play();
    auto const name = [&](int p) { return scene.participants[static_cast<std::size_t>(p)].name; };
    if (stage.through())
        for (int p : stage.chain(result.units_per_window)) result.critical.push_back(name(p));
    for (int p = 0; p < static_cast<int>(scene.participants.size()); ++p) {
        if (auto const wait = stage.wait_of(p); !wait.empty()) result.waits.push_back(wait);
        bool const reads =
            std::any_of(scene.edges.begin(), scene.edges.end(), [&](Edge const& e) { return e.to == p; });
        bool const sends =
            std::any_of(scene.edges.begin(), scene.edges.end(), [&](Edge const& e) { return e.from == p; });
        if (scene.participants.size() > 1 && !reads && !sends) result.alone.push_back(name(p));
        if (reads && !sends) result.unread.push_back(name(p));
        if (sends && !reads) result.leading.push_back(name(p));
    }
    return result;
}

}  // namespace sluice
