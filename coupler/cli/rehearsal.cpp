#include "coupler/cli/rehearsal.hpp"

#include <algorithm>
#include <optional>

namespace sluice {
namespace {

//! A computation: participant `who` in window `window`. Times are in units of one computation.
struct Step
{
    int end = 0;                 //!< when it is done
    int before = -1;             //!< the participant whose result it waited for last; itself: its own last window
    std::int64_t in_window = 0;  //!< the window in which that one computed it
};

class Stage
{
 public:
    explicit Stage(Scene const& scene)
        : scene_(scene), windows_(2 * static_cast<int>(scene.participants.size()) + 4), done_(scene.participants.size())
    {}

    //! Plays until everybody is through, or nobody can go on.
    void play()
    {
        for (bool moved = true; moved;) {
            moved = false;
            for (std::size_t p = 0; p < done_.size(); ++p)
                while (window_of(p) < windows_ && !waiting(static_cast<int>(p))) {
                    compute(static_cast<int>(p));
                    moved = true;
                }
        }
    }

    //! The first edge whose frame has not come.
    std::optional<Edge> waiting(int p) const
    {
        for (Edge const& e : scene_.edges)
            if (e.to == p && window_of(e.from) < needed(e, window_of(p))) return e;
        return std::nullopt;
    }
    std::int64_t window_of(std::size_t p) const { return static_cast<std::int64_t>(done_[p].size()); }
    std::int64_t window_of(int p) const { return window_of(static_cast<std::size_t>(p)); }
    static std::int64_t needed(Edge const& e, std::int64_t window) { return window + 1 - e.lag; }
    bool through() const
    {
        return std::all_of(done_.begin(), done_.end(),
                           [&](auto const& d) { return static_cast<int>(d.size()) == windows_; });
    }

    //! The chain that ended last, from its newest computation backwards, as long as it takes to come round again.
    std::vector<int> chain(double& per_window) const
    {
        auto const at = [&](int p, std::int64_t w) {
            return done_[static_cast<std::size_t>(p)][static_cast<std::size_t>(w)];
        };
        int who = 0;
        for (int p = 1; p < static_cast<int>(done_.size()); ++p)
            if (at(p, windows_ - 1).end > at(who, windows_ - 1).end) who = p;
        std::vector<int> back;
        std::int64_t window = windows_ - 1;
        int const last = who;
        auto const begin = at(who, window).end;
        do {
            back.push_back(who);
            Step const step = at(who, window);
            who = step.before;
            window = step.in_window;
        } while (who >= 0 && who != last);
        per_window =
            who < 0 ? static_cast<double>(begin) / windows_
                    : static_cast<double>(begin - at(who, window).end) / static_cast<double>(windows_ - 1 - window);
        std::reverse(back.begin(), back.end());
        return back;
    }

 private:
    void compute(int p)
    {
        auto& mine = done_[static_cast<std::size_t>(p)];
        auto const window = static_cast<std::int64_t>(mine.size());
        Step step;
        int start = 0;
        if (window > 0) {
            start = mine.back().end;
            step.before = p;
            step.in_window = window - 1;
        }
        for (Edge const& e : scene_.edges) {
            auto const frame = needed(e, window);
            if (e.to != p || frame == 0) continue;
            int const sent = done_[static_cast<std::size_t>(e.from)][static_cast<std::size_t>(frame - 1)].end;
            if (sent <= start) continue;
            start = sent;
            step.before = e.from;
            step.in_window = frame - 1;
        }
        step.end = start + 1;
        mine.push_back(step);
    }

    Scene const& scene_;
    int windows_;
    std::vector<std::vector<Step>> done_;  //!< [participant][window]
};

}  // namespace

Rehearsal rehearse(Scene const& scene)
{
    Rehearsal result;
    auto const name = [&](int p) { return scene.participants[static_cast<std::size_t>(p)].name; };
    if (scene.participants.empty()) return result;
    Stage stage(scene);
    stage.play();
    if (stage.through())
        for (int p : stage.chain(result.units_per_window)) result.critical.push_back(name(p));
    for (int p = 0; p < static_cast<int>(scene.participants.size()); ++p) {
        if (auto const edge = stage.waiting(p); edge && !stage.through())
            result.waits.push_back(name(p) + " waits in window " + std::to_string(stage.window_of(p)) + " for frame " +
                                   std::to_string(Stage::needed(*edge, stage.window_of(p))) + " of " +
                                   scene.data[static_cast<std::size_t>(edge->data)].name + " from " + name(edge->from));
        bool const reads =
            std::any_of(scene.edges.begin(), scene.edges.end(), [&](Edge const& e) { return e.to == p; });
        bool const sends =
            std::any_of(scene.edges.begin(), scene.edges.end(), [&](Edge const& e) { return e.from == p; });
        if (scene.participants.size() > 1 && !reads && !sends) result.alone.push_back(name(p));
        if (reads && !sends) result.unread.push_back(name(p));
    }
    return result;
}

}  // namespace sluice
