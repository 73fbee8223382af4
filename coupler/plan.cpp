// When windows begin and end, what users ask for while a run goes on, and checkpoints: the part of a Session that the
// process which paces the run leads.

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "coupler/session.hpp"

namespace sluice {
namespace {

constexpr std::uint32_t last_bit = 1, checkpoint_bit = 2, stop_bit = 4;
constexpr double longest_run = 1e11;  // windows: ticks are 64-bit

bool has(std::int32_t bits, Request request)
{
    return (bits & static_cast<std::int32_t>(request)) != 0;
}

//! How many windows of `length` ticks cover `left`.
std::int64_t count_of(std::int64_t left, std::int64_t length)
{
    return left / length + (left % length > 0);
}

}  // namespace

void Participant::Session::start_pace()
{
    window_length = choose_window(scene, greetings);
    require(scene.end / window_length < longest_run, [&] {
        return Error(fmt::format("{}: {} s in windows of {} s are more than 1e11 windows. Take longer ones.",
                                 scene.file.string(), scene.end, window_length));
    });
    pace.scale.window = window_length;
    for (Greeting const& g : greetings) {
        if (!g.exact || g.window <= 0) continue;
        pace.exact = true;
        auto const step = pace.scale.ticks(g.window);
        bool const divides = step > 0 && ticks_per_window % step == 0;  // 0: shorter than half a tick
        pace.grain = pace.grain == 0 || !divides ? 0 : std::lcm(pace.grain, step);
    }
    auto const count = static_cast<std::int64_t>(std::ceil(scene.end / window_length - 1e-9));
    pace.end = pace.exact ? count * ticks_per_window : std::max<std::int64_t>(1, pace.scale.ticks(scene.end));
    status->windows = count;
    status->can_store = all_can_store();
}

bool Participant::Session::is_stored_by_count(std::int64_t window) const
{
    return scene.checkpoint.windows > 0 && window >= pace.stored_window + scene.checkpoint.windows;
}

Plan Participant::Session::next_plan(std::int64_t window)
{
    Plan plan{.window = window, .begin = begin_, .length = pace.length};
    auto const left = pace.end - begin_;
    if (!pace.exact) {
        if (plan.length > left)
            plan.length = left;
        else if (left - plan.length > 0 && left - plan.length < plan.length / 100)
            plan.length = (left + 1) / 2;  // two alike instead of one and a sliver
    }
    plan.last = plan.length >= left || !pace.why_over.empty();
    auto const& when = scene.checkpoint;
    bool const possible = all_can_store() && window > 0 && !pending_;
    bool const by_time = when.interval > 0 && Clock::now() - pace.stored > std::chrono::duration<double>(when.interval);
    bool const by_count = is_stored_by_count(window);
    bool const asked = has(pace.requests, Request::checkpoint) || has(pace.requests, Request::stop);
    bool const first = scene.restart_on_death && pace.stored_window == 0;  // else there is nothing to go back to
    plan.checkpoint = possible && (by_time || by_count || asked || first);
    plan.stop = has(pace.requests, Request::stop) && window > 0 && (plan.checkpoint || !all_can_store());
    if (plan.checkpoint) {
        pace.requests = 0;
        pace.stored = Clock::now();
        pace.stored_window = window;
    }
    status->windows = window + count_of(left, pace.length);
    return plan;
}

void Participant::Session::plan_window(std::int64_t window)
{
    look_for_requests();
    if (paces()) {
        if (transport && now() - looked_ > std::chrono::milliseconds(20)) {  // it may wait for nobody
            looked_ = now();
            while (auto const incoming = transport->receive(std::chrono::microseconds(0))) handle(*incoming);
        }
        if (resumed_plan_) {
            told_.push_back(*std::exchange(resumed_plan_, std::nullopt));
            told_.back().checkpoint = told_.back().stop = false;
            told_.back().last = told_.back().begin + told_.back().length >= pace.end;
        } else {
            if (is_stored_by_count(window)) finish_checkpoint();  // a window that was asked for is not left out
            told_.push_back(next_plan(window));
        }
        Plan const& plan = told_.back();
        auto const length = static_cast<std::uint64_t>(plan.length);
        Header header{
            .kind = MessageKind::plan,
            .session = session,
            .columns = (plan.last ? last_bit : 0) | (plan.checkpoint ? checkpoint_bit : 0) | (plan.stop ? stop_bit : 0),
            .frame = window,
            .ticks = plan.begin,
            .points = static_cast<std::uint32_t>(length),
            .iteration = static_cast<std::uint32_t>(length >> 32)};
        seal(header);
        if (transport) broadcast(bytes_of(header));
    } else
        wait_for(pacer, [&] { return !told_.empty(); });
    schedule->planned(told_.front());
    plan_ = told_.front();
    told_.pop_front();
}

void Participant::Session::take_plan(int member, Header const& header)
{
    Plan const plan{.window = header.frame,
                    .begin = header.ticks,
                    .length = static_cast<std::int64_t>(header.points | std::uint64_t{header.iteration} << 32),
                    .last = (header.columns & last_bit) != 0,
                    .checkpoint = (header.columns & checkpoint_bit) != 0,
                    .stop = (header.columns & stop_bit) != 0};
    require(member == pacer && plan.window == next_planned_ && plan.length > 0, [&] {
        return Error(fmt::format("a plan for window {} from \"{}\", where one for window {} from \"{}\" was due: one "
                                 "was lost or doubled.",
                                 plan.window, name_of_member(member), next_planned_, name_of_member(pacer)),
                     Exit::protocol);
    });
    auto const longest = std::numeric_limits<std::int64_t>::max() - next_begin_;
    bool const possible = !plan.checkpoint || status->can_store != 0;
    require(plan.begin == next_begin_ && plan.length <= longest && possible, [&] {
        return Error(
            fmt::format("a plan for window {} from \"{}\", of {} ticks from tick {} on{} (needed: from tick {} "
                        "on, a checkpoint only where all can store their state). Do all participants run the "
                        "same Sluice?",
                        plan.window, name_of_member(member), plan.length, plan.begin,
                        plan.checkpoint ? ", with a checkpoint" : "", next_begin_),
            Exit::protocol);
    });
    ++next_planned_;
    next_begin_ = plan.begin + plan.length;
    status->windows = std::max(plan.window + count_of(pace.end - plan.begin, plan.length), plan.window + 1);
    told_.push_back(plan);
}

//! What a user asked of this process: it goes to the one who paces.
void Participant::Session::look_for_requests()
{
    std::int32_t bits = asked_by_signal();
    if (status->request.load(std::memory_order_relaxed) != 0) bits |= status->request.exchange(0);
    if (bits == 0) return;
    if (paces() || !transport) return take_request(bits);
    Header header{.kind = MessageKind::request, .session = session, .columns = static_cast<std::uint32_t>(bits)};
    seal(header);
    send(pacer, bytes_of(header), Clock::time_point::max());
}

void Participant::Session::take_request(std::int32_t bits)
{
    pace.requests |= bits;
}

bool Participant::Session::all_can_store() const
{
    return !options.given && std::all_of(greetings.begin(), greetings.end(), [](auto const& g) { return g.can_store; });
}

State Participant::Session::state_before(std::int64_t window) const
{
    State state;
    state.put_integer("window", window);
    state.put_integer("begin", plan_.begin);
    state.put_integer("length", plan_.length);
    state.put_integer("next_length", pace.length);
    state.put_number("first_window", window_length);
    for (auto const& channel : in) {
        auto const edge = "in" + std::to_string(channel.number) + "/";
        state.put_integer(edge + "frames", static_cast<std::int64_t>(channel.history.size()));
        std::vector<std::int64_t> origins;
        if (channel.origins.size() > 1)
            for (auto const id : channel.history.front().ids.values) origins.push_back(channel.origin_of(id));
        state.put(edge + "origins", std::span<std::int64_t const>(origins));
        for (std::size_t k = 0; k < channel.history.size(); ++k) {
            auto const& frame = channel.history[k];
            auto const name = edge + std::to_string(k) + "/";
            state.put_integer(name + "index", frame.index);
            state.put_integer(name + "ticks", frame.ticks);
            state.put(name + "ids", frame.ids.values);
            for (std::size_t c = 0; c < frame.columns.size(); ++c)
                state.put(name + std::to_string(c), frame.columns[c].values);
        }
    }
    if (group_part_) group_part_->put(state);
    State solver;
    save(solver);
    state.nest("solver", std::move(solver));
    return state;
}

void Participant::Session::store(std::int64_t window)
{
    book(Activity::exchange);
    auto const part = store_->write_part(window, name_of_member(self), state_before(window));
    for (auto& channel : out)
        for (auto& target : channel.targets) target.encoder.forget();
    if (paces())
        pending_ = Manifest{.version = SLUICE_VERSION,
                            .scene = physics_hash(scene),
                            .window = window,
                            .ticks = plan_.begin,
                            .tick = window_length / static_cast<double>(ticks_per_window),
                            .previous = {},
                            .members = {}};
    if (paces()) return take_report(self, window, part.line());
    send(pacer, encode_text({.kind = MessageKind::stored, .session = session, .frame = window}, part.line()),
         Clock::time_point::max());
    book(Activity::exchange);
}

void Participant::Session::take_report(int member, std::int64_t window, std::string const& line)
{
    auto const part = CheckpointPart::parse(line);
    if (!pending_ && paces()) {  // it was faster than the one who paces
        early_reports_.emplace_back(member, line);
        return;
    }
    require(pending_ && part && part->member == name_of_member(member) && pending_->window == window, [&] {
        return Error("a report of \"" + name_of_member(member) + "\" about a checkpoint that is not being taken.",
                     Exit::protocol);
    });
    pending_->members.push_back(*part);
    if (member == self)
        for (auto const& [who, text] : std::exchange(early_reports_, {})) take_report(who, window, text);
    if (!pending_ || pending_->members.size() < members.size()) return;
    auto const remark = store_->commit(*pending_);
    if (!remark.empty()) warnings.push_back(remark);
    status->checkpoint = window;
    pending_.reset();
}

void Participant::Session::finish_checkpoint()
{
    if (!paces()) return;
    for (int m = 0; m < static_cast<int>(members.size()); ++m)
        wait_for(m, [&] { return !pending_ || pending_->part_of(name_of_member(m)); });
}

void Participant::Session::find_checkpoint()
{
    store_ = std::make_unique<CheckpointStore>(options.directory, scene.checkpoint.keep);
    if (save) store_->prepare();
    if (options.resume) return load_newest();
    if (paces()) store_->discard_after(-1);  // of an earlier run: nobody shall go on from there
}

void Participant::Session::load_newest()
{
    require(static_cast<bool>(restore), [&] {
        return Error("participant \"" + name_of_member(self) +
                         "\" cannot be resumed: its solver does not keep its state. Start the run anew.",
                     Exit::config);
    });
    auto const found = store_->newest();
    if (!found.note.empty()) warnings.push_back(found.note);
    require(found.manifest.has_value(), [&] {
        return Error(options.directory.string() + ": no complete checkpoint to go on from. " + found.note, Exit::io);
    });
    require(found.manifest->scene == physics_hash(scene), [&] {
        return Error(options.directory.string() +
                         ": its checkpoint is of another scene. Only time.end, checkpoint, timeouts and on-death may "
                         "change.",
                     Exit::protocol);
    });
    auto const file = store_->part_file(found.manifest->window, name_of_member(self)).string();
    resumed_ = State::decode(store_->read_part(*found.manifest, name_of_member(self)), file);
    mine().resumes = found.manifest->window;
    status->checkpoint = found.manifest->window;
    if (paces()) store_->discard_after(found.manifest->window);  // before anybody can write a part of a newer one
}

//! The one who paces commits checkpoints: a newer one may have become complete after this process had looked.
void Participant::Session::agree_on_checkpoint()
{
    if (std::any_of(greetings.begin(), greetings.end(), [](auto const& g) { return g.resumes < 0; })) return;
    auto const agreed = greetings[static_cast<std::size_t>(pacer)].resumes;
    if (mine().resumes != agreed) load_newest();
    for (std::size_t m = 0; m < greetings.size(); ++m)
        if (static_cast<int>(m) != self) greetings[m].resumes = agreed;
}

//! After everybody was met: the channels and the solver as they were at the checkpoint.
void Participant::Session::resume()
{
    for (std::size_t m = 0; m < members.size(); ++m)
        require(greetings[m].resumes == mine().resumes, [&] {
            return Error(fmt::format("\"{}\" goes on from window {}, \"{}\" from window {} (-1: from the beginning). "
                                     "Start all of them with --resume, or none.",
                                     name_of_member(self), mine().resumes, name_of_member(static_cast<int>(m)),
                                     greetings[m].resumes),
                         Exit::protocol);
        });
    if (!resumed_) return;
    State state = *std::exchange(resumed_, std::nullopt);
    auto const window = state.integer("window");
    begin_ = state.integer("begin");
    pace.length = state.integer("next_length");
    pace.stored_window = window;
    pace.stored = Clock::now();
    next_planned_ = window;
    next_begin_ = begin_;
    window_length = pace.scale.window = state.number("first_window");
    resumed_plan_ = Plan{.window = window, .begin = begin_, .length = state.integer("length")};
    resumed_at = pace.scale.seconds(begin_);
    for (auto& channel : in) {
        auto const edge = "in" + std::to_string(channel.number) + "/";
        for (auto k = state.integer(edge + "frames") - 1; k >= 0; --k) {
            auto const name = edge + std::to_string(k) + "/";
            Frame frame{.index = state.integer(name + "index"),
                        .ticks = state.integer(name + "ticks"),
                        .iteration = 0,
                        .ids = Held<std::int64_t>::copy_of(state.integers(name + "ids")),
                        .columns = {}};
            for (std::size_t c = 0; c < channel.spec.columns.size(); ++c)
                frame.columns.push_back(Held<double>::copy_of(state.numbers(name + std::to_string(c))));
            channel.history.push_front(std::move(frame));
        }
        channel.set_origins(state.integers(edge + "origins"));
        for (auto& origin : channel.origins) origin.frame = window;
    }
    for (auto& channel : out) {
        channel.written = window;
        for (auto& target : channel.targets) target.used = window;
    }
    restore(state.take("solver"));
    if (group) resumed_group_ = std::move(state);
}

void Participant::Session::require_pace(char const* what) const
{
    require(participant == scene.pace, [&] {
        return Error("participant \"" + name_of_member(self) + "\" " + what + ", but \"" + name_of_member(pacer) +
                     "\" paces this run. Set time.pace: " + options.name + ".");
    });
}

void Participant::Session::end_run(std::string const& why)
{
    require_pace("ends the run");
    pace.why_over = why;
    facts["ended early"] = why;
}

void Participant::Session::set_next_window(double seconds)
{
    require_pace("chooses a window's length");
    require(pace.grain > 0 && seconds > 0, [&] {
        return Error(seconds > 0 ? "windows cannot change their length: the participants' exact steps have no common "
                                   "divisor that ticks can express."
                                 : fmt::format("a window of {} s (must be > 0).", seconds));
    });
    double const wanted = seconds / window_length * static_cast<double>(ticks_per_window);
    auto const ticks = static_cast<std::int64_t>(std::min(wanted * (1 + 1e-12), 4e18));
    pace.length = std::max<std::int64_t>(pace.grain, ticks / pace.grain * pace.grain);
}

}  // namespace sluice
